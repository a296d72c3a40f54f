// Luma stretched so that the low percentile becomes black and the high one white; a range below
// 8 levels of 255 counts as 8. Paper, section 4.2 D.
float equalize(float luma, vec2 measured) {
    float range = max(measured.y - measured.x, 8.0 / 255.0);
    return clamp((luma - measured.x) / range, 0.0, 1.0);
}
