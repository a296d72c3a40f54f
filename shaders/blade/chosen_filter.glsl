#include "lib/filter_number.glsl"
#include "lib/window_tensor.glsl"

#ifdef PREPARED_ROOM
void chosen_filter_prepare(int radius, float window[16]) {
    prepare_tensor_lines(radius, window);
}
#endif

// The index of the filter selected by the local structure, in a compute pass.
float chosen_filter(ivec2 at, int radius, float window[16], vec3 bins, vec2 start, vec2 density) {
    return filter_number(window_tensor(at, radius, window), bins, start, density);
}
