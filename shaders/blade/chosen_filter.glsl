#include "lib/short_angle.glsl"

// The number of the filter that the local structure chooses: orientation, strength and coherence of the
// smoothed structure tensor in uniform bins. Paper, section 4.3. `bins` are the numbers of bins, `start`
// and `density` where the ranges of strength and coherence begin and how many bins a unit of them holds;
// `window` is one half of the even Gaussian, from its end to its middle.
float chosen_filter(ivec2 at, int reach, float window[16], vec3 bins, vec2 start, vec2 density) {
    vec3 tensor = vec3(0.0);
    for (int row = 0; row < 2 * reach; row++) {
        ivec2 corner = at + ivec2(-reach, row - reach);
        float upper = picture_at(corner), lower = picture_at(corner + ivec2(0, 1));
        vec3 line = vec3(0.0);
        for (int column = 0; column < 2 * reach; column++) {
            corner.x += 1;
            float next_upper = picture_at(corner), next_lower = picture_at(corner + ivec2(0, 1));
            float falling = next_lower - upper, rising = next_upper - lower;
            float weight = window[min(column, 2 * reach - 1 - column)];
            line += weight * vec3(falling * falling, falling * rising, rising * rising);
            upper = next_upper;
            lower = next_lower;
        }
        tensor += window[min(row, 2 * reach - 1 - row)] * line;
    }
    tensor *= 0.5;
    vec2 direction = vec2(2.0 * tensor.y, tensor.x - tensor.z);
    float total = tensor.x + tensor.z, spread = length(direction);
    float other = sqrt(max(tensor.x * tensor.z - tensor.y * tensor.y, 0.0));
    float coherence = spread / (total + 2.0 * other + 1e-12);
    float strength = sqrt(0.5 * (total + spread));
    float orientation = floor(short_angle(direction) * bins.x / 6.28318531 + 0.5);
    orientation += orientation < 0.0 ? bins.x : 0.0;
    vec2 levels = floor(clamp((vec2(strength, coherence) - start) * density, vec2(0.0), bins.yz - 0.5));
    // Kept in a texture of luma between passes: all numbers of bins below 1024 survive that.
    return ((orientation * bins.y + levels.x) * bins.z + levels.y) / 1024.0;
}
