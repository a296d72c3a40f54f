#include "lib/filter_number.glsl"
#include "lib/line_angle.glsl"

// A weight of the even Gaussian; `window` is one half of it, from its end to its middle. 0 outside of the window.
float window_weight(int tap, int radius, float window[16]) {
    return tap < 0 || tap >= 2 * radius ? 0.0 : window[min(tap, 2 * radius - 1 - tap)];
}

struct FourTensors {
    vec3 upper_left, upper_right, lower_left, lower_right;
};

// The structure tensors of 2 x 2 pixels: their windows share most of the differences, and each read returns four
// pixels. Paper, section 6.3.
FourTensors four_tensors(ivec2 at, int radius, float window[16]) {
    FourTensors found = FourTensors(vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0));
    for (int row = 0; row <= 2 * radius; row++) {
        vec3 left = vec3(0.0), right = vec3(0.0);
        vec2 before = vec2(0.0);
        float weight_before = 0.0, weight_two_before = 0.0;
        for (int column = 0; column <= 2 * radius; column += 2) {
            vec4 quad = quad_at(2 * at + ivec2(column, row) - radius);
            float falling = quad.x - before.x, rising = quad.w - before.y;
            vec3 between = vec3(falling * falling, falling * rising, rising * rising);
            falling = quad.y - quad.w;
            rising = quad.z - quad.x;
            vec3 inside = vec3(falling * falling, falling * rising, rising * rising);
            float weight = window_weight(column, radius, window);
            left += weight_before * between + weight * inside;
            right += weight_two_before * between + weight_before * inside;
            before = quad.zy;
            weight_two_before = weight;
            weight_before = window_weight(column + 1, radius, window);
        }
        float weight = window_weight(row, radius, window);
        found.upper_left += weight * left;
        found.upper_right += weight * right;
        weight = window_weight(row - 1, radius, window);
        found.lower_left += weight * left;
        found.lower_right += weight * right;
    }
    return found;
}

// The indices of the filters selected for 2 x 2 pixels, row by row, in a fragment pass.
vec4 chosen_filters(ivec2 at, int radius, float window[16], vec3 bins, vec2 start, vec2 density) {
    FourTensors of = four_tensors(at, radius, window);
    return vec4(
        filter_number(of.upper_left, bins, start, density), filter_number(of.upper_right, bins, start, density),
        filter_number(of.lower_left, bins, start, density), filter_number(of.lower_right, bins, start, density));
}

// The angles for computing curvatures, also for 2 x 2 pixels.
vec4 four_angles(ivec2 at, int radius, float window[16]) {
    FourTensors of = four_tensors(at, radius, window);
    return vec4(
        line_angle(of.upper_left), line_angle(of.upper_right),
        line_angle(of.lower_left), line_angle(of.lower_right));
}
