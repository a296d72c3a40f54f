#include "lib/short_angle.glsl"
#include "lib/tensor_line.glsl"

#if __VERSION__ >= 430
shared vec3 tensor_lines[PREPARED_ROOM];
bool lines_fit;

// In a compute group each line serves all pixels above and below it. The differences themselves are not kept:
// to read three numbers from shared memory costs more than to make them anew of two.
void chosen_filter_prepare(int reach, float window[16]) {
    int rows = group_size.y + 2 * reach - 1;
    lines_fit = group_size.x * rows <= PREPARED_ROOM;
    ivec2 own = ivec2(gl_LocalInvocationID.xy), next = ivec2(gl_WorkGroupSize.xy);
    for (int y = own.y; lines_fit && y < rows; y += next.y) {
        for (int x = own.x; x < group_size.x; x += next.x) {
            tensor_lines[y * group_size.x + x] =
                tensor_line(group_first + ivec2(x, y - reach), reach, window);
        }
    }
    barrier();
}

vec3 tensor_line_at(ivec2 at, int reach, float window[16]) {
    ivec2 inside = at - group_first + ivec2(0, reach);
    return lines_fit ? tensor_lines[inside.y * group_size.x + inside.x] : tensor_line(at, reach, window);
}
#else
vec3 tensor_line_at(ivec2 at, int reach, float window[16]) {
    return tensor_line(at, reach, window);
}
#endif

// The number of the filter that the local structure chooses: orientation, strength and coherence of the
// smoothed structure tensor in uniform bins. Paper, section 4.3. `bins` are the numbers of bins, `start`
// and `density` where the ranges of strength and coherence begin and how many bins a unit of them holds.
float chosen_filter(ivec2 at, int reach, float window[16], vec3 bins, vec2 start, vec2 density) {
    vec3 tensor = vec3(0.0);
    for (int row = 0; row < 2 * reach; row++) {
        vec3 line = tensor_line_at(at + ivec2(0, row - reach), reach, window);
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
