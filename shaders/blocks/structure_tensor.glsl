#include "lib/sobel_gradient.glsl"

// Direction and strength of edges as colours: doubled angles, weighted by the root of the gradient's magnitude.
vec3 structure_tensor(ivec2 at, vec3 weights) {
    channels across, down; // of RGB
    sobel_gradient(at, across, down);
    vec2 gradient = 0.25 * vec2(dot(across, weights), dot(down, weights));
    float squared = dot(gradient, gradient);
    float strength = sqrt(min(sqrt(squared), 1.0));
    float each = 0.5 * strength / max(squared, 1e-20);
    float twice_x = gradient.x * gradient.x - gradient.y * gradient.y, twice_y = 2.0 * gradient.x * gradient.y;
    return vec3(0.5 + each * twice_x, 0.5 + each * twice_y, strength);
}
