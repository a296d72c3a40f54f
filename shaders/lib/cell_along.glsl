// The mean over a cell of the page along one direction, up to the border of the page. `side` is 1 or more pixels.
channels cell_along(ivec2 at, ivec2 next, int side, ivec2 page) {
    int own = at.x * next.x + at.y * next.y, end = page.x * next.x + page.y * next.y;
    int first = own / side * side, last = min(first + side, end);
    ivec2 place = at + (first - own) * next;
    channels sum = picture_at(place);
    for (int each = first + 1; each < last; each++) {
        place += next;
        sum += picture_at(place);
    }
    return sum / float(last - first);
}
