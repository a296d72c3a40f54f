#include "lib/gaussian_along.glsl"

// Horizontal pass of the Gaussian filter. Paper, section 4.2 B.
channels gaussian_across(ivec2 at, float sigma) {
    return gaussian_along(at, ivec2(1, 0), sigma);
}

// Vertical pass on the result.
channels gaussian(ivec2 at, float sigma) {
    return gaussian_along(at, ivec2(0, 1), sigma);
}
