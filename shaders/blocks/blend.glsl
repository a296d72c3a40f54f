#include "lib/hard_light.glsl"
#include "lib/quotient.glsl"

// A saved picture blended over the current one.
channels blend(channels picture, channels other, int mode, float opacity, float mask) {
    channels mixed = other;
    if (mode == blend_mode_multiply)
        mixed = picture * other;
    else if (mode == blend_mode_screen)
        mixed = picture + other - picture * other;
    else if (mode == blend_mode_overlay)
        mixed = hard_light(other, picture);
    else if (mode == blend_mode_hard_light)
        mixed = hard_light(picture, other);
    else if (mode == blend_mode_soft_light)
        mixed = picture * (2.0 * other + picture * (1.0 - 2.0 * other));
    else if (mode == blend_mode_darken)
        mixed = min(picture, other);
    else if (mode == blend_mode_lighten)
        mixed = max(picture, other);
    else if (mode == blend_mode_add)
        mixed = min(picture + other, 1.0);
    else if (mode == blend_mode_subtract)
        mixed = max(picture - other, 0.0);
    else if (mode == blend_mode_difference)
        mixed = abs(picture - other);
    else if (mode == blend_mode_grain_extract)
        mixed = clamp(picture - other + 0.5, 0.0, 1.0);
    else if (mode == blend_mode_grain_merge)
        mixed = min(max(picture + other - 0.5, 0.0), max(picture, 1.0));
    else if (mode == blend_mode_divide)
        mixed = quotient(picture, other);
    else if (mode == blend_mode_dodge)
        mixed = quotient(picture, 1.0 - other);
    else if (mode == blend_mode_burn)
        mixed = 1.0 - quotient(1.0 - picture, other);
    return mix(picture, mixed, opacity * mask);
}
