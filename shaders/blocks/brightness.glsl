// Luma multiplied by a factor, clipped to black and white. Paper, section 4.2 A.
float brightness(float luma, float factor) {
    return clamp(luma * factor, 0.0, 1.0);
}
