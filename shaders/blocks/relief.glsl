#include "lib/sobel_gradient.glsl"

// Luma as a height, lit from the side: half white plus the slope towards the light, 3 x 3 Sobel divided by 8.
float relief(ivec2 at, float depth, float angle) {
    float across, down, turn = radians(angle);
    sobel_gradient(at, across, down);
    return clamp(0.5 + 0.125 * depth * (down * sin(turn) - across * cos(turn)), 0.0, 1.0);
}
