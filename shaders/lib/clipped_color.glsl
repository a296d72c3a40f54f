// RGB clipped to 0..1; white highlights of HDR, above 1, to the smallest channel that they had before.
vec3 clipped_color(vec3 color, vec3 before) {
    return clamp(color, 0.0, max(min(before.r, min(before.g, before.b)), 1.0));
}
