// The light tones of each channel inverted: min(x, t (1 - x) / (1 - t)), where t is the threshold.
vec3 solarize(vec3 picture, float threshold) {
    float t = threshold / 255.0;
    return min(picture, (1.0 - picture) * (t / (1.0 - t)));
}
