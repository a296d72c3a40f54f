#include "lib/white_noise.glsl"

// The noise of one lattice between its points, with a mean of 0; `number` identifies the lattice.
float octave_of_noise(vec2 place, int number) {
    ivec2 low = ivec2(floor(place)), first = low + number * APART;
    vec2 part = place - vec2(low);
    part = part * part * (3.0 - 2.0 * part);
    float above = mix(white_noise(first), white_noise(first + ivec2(1, 0)), part.x);
    float below = mix(white_noise(first + ivec2(0, 1)), white_noise(first + 1), part.x);
    return mix(above, below, part.y) - 0.5;
}
