#include "lib/pure_hue.glsl"

// The tones of one hue, from black through the hue to white: HSL with luma as the lightness.
// Paper, section 4.2 A.
vec3 colorize(vec3 picture, vec3 weights, float hue, float saturation) {
    float lightness = clamp(dot(picture, weights), 0.0, 1.0);
    float span = (1.0 - abs(2.0 * lightness - 1.0)) * saturation;
    return lightness + span * (pure_hue(hue) - 0.5);
}
