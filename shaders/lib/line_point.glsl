// The pixel of a number, -6 to 6, on a line of some length through the origin: eight directions, clockwise from
// the right.
ivec2 line_point(int direction, int number, int reach) {
    int column = 2 - max(direction - 2, 0), row = direction < 7 ? min(direction, 2) : 1;
    vec2 half_step = vec2(max(column, -2), row);
    float steps = floor(float(reach) / length(0.5 * half_step) + 0.5);
    return ivec2(floor((float(number) * steps * half_step + 6.5) / 12.0));
}
