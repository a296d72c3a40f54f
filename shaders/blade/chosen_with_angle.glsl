#include "lib/filter_number.glsl"
#include "lib/line_angle.glsl"
#include "lib/window_tensor.glsl"

#ifdef PREPARED_ROOM
void chosen_with_angle_prepare(int radius, float window[16]) {
    prepare_tensor_lines(radius, window);
}
#endif

// The index of the filter selected by the local structure except curvature, and the angle for computing the
// curvature, in a compute pass.
vec2 chosen_with_angle(ivec2 at, int radius, float window[16], vec3 bins, vec2 start, vec2 density) {
    vec3 tensor = window_tensor(at, radius, window);
    return vec2(filter_number(tensor, bins, start, density), line_angle(tensor));
}
