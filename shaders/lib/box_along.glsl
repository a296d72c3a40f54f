// The mean of the picture along a line of 2 int(cell / 2) + 1 pixels.
vec3 box_along(ivec2 at, ivec2 next, float cell) {
    int radius = int(0.5 * cell);
    vec3 sum = vec3(0.0);
    ivec2 from = at - radius * next;
    for (int tap = 0; tap <= 2 * radius; tap++, from += next)
        sum += picture_at(from);
    return sum / float(2 * radius + 1);
}
