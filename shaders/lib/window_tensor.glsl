#include "lib/tensor_line.glsl"

#ifdef PREPARED_ROOM
shared vec3 tensor_lines[PREPARED_ROOM];

// Each line of the tensor is used by all pixels of the group above and below it. The differences are not stored:
// reading three numbers from shared memory costs more than computing them from two.
void prepare_tensor_lines(int radius, float window[16]) {
    ivec2 own = ivec2(gl_LocalInvocationID.xy), next = ivec2(gl_WorkGroupSize.xy);
    for (int y = own.y; y < group_size.y + 2 * radius - 1; y += next.y) {
        for (int x = own.x; x < group_size.x; x += next.x) {
            tensor_lines[y * group_size.x + x] =
                tensor_line(group_first + ivec2(x, y - radius), radius, window);
        }
    }
    barrier();
}

vec3 tensor_line_at(ivec2 at, int radius, float window[16]) {
    ivec2 inside = at - group_first + ivec2(0, radius);
    return tensor_lines[inside.y * group_size.x + inside.x];
}
#else
vec3 tensor_line_at(ivec2 at, int radius, float window[16]) {
    return tensor_line(at, radius, window);
}
#endif

// The structure tensor in the window around a pixel.
vec3 window_tensor(ivec2 at, int radius, float window[16]) {
    vec3 tensor = vec3(0.0);
    for (int row = 0; row < 2 * radius; row++) {
        vec3 line = tensor_line_at(at + ivec2(0, row - radius), radius, window);
        tensor += window[min(row, 2 * radius - 1 - row)] * line;
    }
    return tensor;
}
