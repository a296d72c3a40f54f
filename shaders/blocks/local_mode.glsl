// The mean of the pixels of a square, weighted by a power of the histogram at their tone. The histogram has
// 32 tones; a pixel between two of them counts for both, in steps of 1/256.
float local_mode(ivec2 at, int radius, int exponent, float amount) {
    float counts[32], tones[32];
    for (int level = 0; level < 32; level++)
        counts[level] = tones[level] = 0.0;
    for (int row = -radius; row <= radius; row++)
        for (int column = -radius; column <= radius; column++) {
            float tone = clamp(picture_at(at + ivec2(column, row)), 0.0, 1.0);
            int level = clamp(int(tone * 31.0), 0, 30);
            float upper = floor((tone * 31.0 - float(level)) * 256.0 + 0.5) / 256.0;
            counts[level] += 1.0 - upper;
            counts[level + 1] += upper;
            tones[level] += (1.0 - upper) * tone;
            tones[level + 1] += upper * tone;
        }
    float total = 0.0, count = 0.0;
    for (int level = 0; level < 32; level++) {
        float weight = 1.0;
        for (int power = 1; power < exponent; power++)
            weight *= counts[level] / 289.0;
        total += weight * tones[level];
        count += weight * counts[level];
    }
    float own = picture_at(at);
    return own + amount * (total / count - own);
}
