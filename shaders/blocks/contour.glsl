#include "lib/sobel_gradient.glsl"

// Edges of brightness and of colour: e^2 / (e^2 + n^2 + c^2), with e the gradient over all channels, n the
// threshold and c the clutter times the sparsity.
vec3 contour(ivec2 at, float clutter, vec3 weights, float threshold, float sparsity) {
    channels across, down; // of RGB
    sobel_gradient(at, across, down);
    float squared = 0.0625 * dot(across * across + down * down, weights);
    float least = threshold / 255.0, around = sparsity * clutter;
    return vec3(squared / max(squared + least * least + around * around, 1e-12));
}
