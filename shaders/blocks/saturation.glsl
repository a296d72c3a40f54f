#include "lib/clipped_color.glsl"

// Colours more vivid or more muted: gray + factor (RGB - gray). Paper, section 4.2 A.
vec3 saturation(vec3 picture, vec3 weights, float factor) {
    float gray = dot(picture, weights);
    return clipped_color(gray + factor * (picture - gray), picture);
}
