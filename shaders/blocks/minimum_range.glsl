// Luma expanded about its middle to a minimum range, in levels of 255; pictures with a larger range are
// unchanged. A range below 8 levels counts as 8. Paper, section 4.2 D.
float minimum_range(float luma, vec2 measured, float dynamic_range) {
    // Compared in levels, so that rounding in a division cannot make equal ranges differ.
    float present = max((measured.y - measured.x) * 255.0, 8.0);
    if (present >= dynamic_range)
        return luma;
    float middle = 0.5 * (measured.x + measured.y);
    float half_wanted = dynamic_range / 510.0;
    float moved = clamp(middle, half_wanted, 1.0 - half_wanted);
    return clamp((luma - middle) * (dynamic_range / present) + moved, 0.0, 1.0);
}
