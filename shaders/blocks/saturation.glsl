// Colours more vivid or more muted: gray + factor (RGB - gray). Paper, section 4.2 A.
vec3 saturation(vec3 picture, vec3 weights, float factor) {
    float gray = dot(picture, weights);
    return clamp(gray + factor * (picture - gray), 0.0, 1.0);
}
