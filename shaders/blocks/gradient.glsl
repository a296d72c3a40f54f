// The tones of the picture in five colours, with a linear gradient between them.
vec3 gradient(vec3 picture, vec3 weights, vec3 black, vec3 dark, vec3 middle, vec3 bright, vec3 white) {
    float place = clamp(4.0 * dot(picture, weights), 0.0, 4.0);
    if (place < 1.0)
        return mix(black, dark, place);
    if (place < 2.0)
        return mix(dark, middle, place - 1.0);
    if (place < 3.0)
        return mix(middle, bright, place - 2.0);
    return mix(bright, white, place - 3.0);
}
