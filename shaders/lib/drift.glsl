// Marks move with the film: distance of a mark from the square that shows it, in squares of the grid. None have
// moved if the drift is a single cell.
int max_drift_squares() {
    return textureSize(drift, 0) == ivec2(1) ? 0 : 1;
}

// How far the mark that a square of a grid shows has moved, in squares. `drift` is relative to the page.
vec2 drift_of(ivec2 square, float pitch, ivec2 page) {
    ivec2 size = textureSize(drift, 0);
    vec2 place = (vec2(square) + 0.5) * pitch / vec2(page);
    ivec2 cell = clamp(ivec2(floor(place * vec2(size))), ivec2(0), size - 1);
    return texelFetch(drift, cell, 0).xy * vec2(page) / pitch;
}
