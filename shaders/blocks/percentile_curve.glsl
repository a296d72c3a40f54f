// Luma after a curve through four percentiles, with straight lines between and beyond them, clipped to 0..1.
// If `straight`, the inner points are at thirds; a distance below 2 levels of 255 counts as 2.
float percentile_curve(
    float luma, vec4 measured, float level_dark, float level_low, float level_high, float level_bright,
    bool straight, float amount
) {
    const float gap = 2.0 / 255.0;
    float third = (measured.w - measured.x) / 3.0;
    float low = max(straight ? measured.x + third : measured.y, measured.x + gap);
    float high = max(straight ? measured.x + 2.0 * third : measured.z, low + gap);
    float bright = max(measured.w, high + gap);
    vec2 from = luma < low ? vec2(measured.x, level_dark) : vec2(low, level_low);
    vec2 to = luma < low ? vec2(low, level_low) : vec2(high, level_high);
    from = luma < high ? from : vec2(high, level_high);
    to = luma < high ? to : vec2(bright, level_bright);
    float tone = from.y + (luma - from.x) * ((to.y - from.y) / (to.x - from.x));
    return luma + amount * (clamp(tone, 0.0, 1.0) - luma);
}
