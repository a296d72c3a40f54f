#include "lib/sobel_gradient.glsl"

// Magnitude of the luma gradient: 3 x 3 Sobel divided by 4, clipped at white. Paper, section 4.2 B.
float sobel(ivec2 at, float gain, bool invert) {
    float across, down;
    sobel_gradient(at, across, down);
    float edge = min(0.25 * gain * length(vec2(across, down)), 1.0);
    return invert ? 1.0 - edge : edge;
}
