#include "lib/short_angle.glsl"

// The index of the filter that a smoothed structure tensor selects, in 1024ths, so that a texture can store it:
// orientation, strength and coherence in uniform bins. Paper, section 5.3. `bins` are the numbers of bins;
// `start` and `density` are the start of the ranges of strength and coherence and the number of bins per unit.
float filter_number(vec3 tensor, vec3 bins, vec2 start, vec2 density) {
    tensor *= 0.5;
    vec2 direction = vec2(2.0 * tensor.y, tensor.x - tensor.z);
    float total = tensor.x + tensor.z, spread = length(direction);
    float other = sqrt(max(tensor.x * tensor.z - tensor.y * tensor.y, 0.0));
    float coherence = spread / (total + 2.0 * other + 1e-12);
    float strength = sqrt(0.5 * (total + spread));
    float orientation = floor(short_angle(direction) * bins.x / 6.28318531 + 0.5);
    orientation = min(orientation + (orientation < 0.0 ? bins.x : 0.0), bins.x - 1.0);
    vec2 levels = floor(clamp((vec2(strength, coherence) - start) * density, vec2(0.0), bins.yz - 0.5));
    return ((orientation * bins.y + levels.x) * bins.z + levels.y) / 1024.0;
}
