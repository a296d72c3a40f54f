// The structure tensor between two rows of pixels, smoothed along them: squares and product of the
// differences along both diagonals of 2 x 2 pixels. `at` is the pixel on the upper row, half a pixel to the
// right of the middle; `window` is one half of the even Gaussian, from its end to its middle.
vec3 tensor_line(ivec2 at, int radius, float window[16]) {
    ivec2 corner = at - ivec2(radius, 0);
    float upper = picture_at(corner), lower = picture_at(corner + ivec2(0, 1));
    vec3 line = vec3(0.0);
    for (int column = 0; column < 2 * radius; column++) {
        corner.x += 1;
        float next_upper = picture_at(corner), next_lower = picture_at(corner + ivec2(0, 1));
        float falling = next_lower - upper, rising = next_upper - lower;
        float weight = window[min(column, 2 * radius - 1 - column)];
        line += weight * vec3(falling * falling, falling * rising, rising * rising);
        upper = next_upper;
        lower = next_lower;
    }
    return line;
}
