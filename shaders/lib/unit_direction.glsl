// Cosine and sine of an angle of -90 to 90 degrees, accurate to the last bit of float32: the GPU's functions are so
// inaccurate that strokes far from the page's corner would move.
vec2 unit_direction(float degrees) {
    bool steep = abs(degrees) > 45.0;
    float x = (steep ? 90.0 - abs(degrees) : degrees) * 0.01745329252;
    float x2 = x * x;
    float sine = x - x * x2 * (1.0 / 6.0 - x2 * (1.0 / 120.0 - x2 * (1.0 / 5040.0 - x2 / 362880.0)));
    float cosine = 1.0 / 720.0 - x2 * (1.0 / 40320.0 - x2 / 3628800.0);
    cosine = 1.0 - x2 * (0.5 - x2 * (1.0 / 24.0 - x2 * cosine));
    return steep ? vec2(sine, degrees < 0.0 ? -cosine : cosine) : vec2(cosine, sine);
}
