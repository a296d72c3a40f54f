// The RGB colour with full saturation and half lightness of a hue in degrees: 0 red, 120 green, 240 blue.
vec3 pure_hue(float degrees) {
    vec3 position = mod(degrees / 60.0 + vec3(0.0, 4.0, 2.0), 6.0);
    return clamp(abs(position - 3.0) - 1.0, 0.0, 1.0);
}
