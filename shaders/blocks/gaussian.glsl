#include "lib/gaussian_along.glsl"

// The Gaussian mean along the rows. Paper, section 4.2 B.
channels gaussian_across(ivec2 at, float sigma) {
    return gaussian_along(at, ivec2(1, 0), sigma);
}

// The Gaussian mean down the columns of that.
channels gaussian(ivec2 at, float sigma) {
    return gaussian_along(at, ivec2(0, 1), sigma);
}
