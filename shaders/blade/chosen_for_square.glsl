#include "lib/filter_number.glsl"

// The index of the filter that 2 x 2 pixels share, for each of them, in a pass of half the size. The window is centred
// on the middle of the square; `window` is one half of its odd Gaussian, from its end to its middle.
vec4 chosen_for_square(ivec2 at, int radius, float window[16], vec3 bins, vec2 start, vec2 density) {
    vec3 tensor = vec3(0.0);
    int last = 2 * radius - 2;
    for (int row = 0; row <= last; row++) {
        vec3 line = vec3(0.0);
        for (int column = 0; column <= last; column++) {
            vec4 quad = quad_at(2 * at + ivec2(column, row) + 1 - radius);
            float falling = quad.y - quad.w, rising = quad.z - quad.x;
            vec3 products = vec3(falling * falling, falling * rising, rising * rising);
            line += window[min(column, last - column)] * products;
        }
        tensor += window[min(row, last - row)] * line;
    }
    return vec4(filter_number(tensor, bins, start, density));
}
