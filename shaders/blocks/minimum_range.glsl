#include "lib/dim_lift.glsl"

// Luma expanded about its middle to a minimum range, in levels of 255; pictures with a larger range keep
// theirs. A range below 8 levels counts as 8. Paper, section 4.2 D. Then a dim picture is brightened.
float minimum_range(float luma, vec4 measured, float dynamic_range, float lift) {
    // Compared in levels, so that rounding in a division cannot make equal ranges differ.
    float present = max((measured.w - measured.x) * 255.0, 8.0);
    float tone = 0.5 * (measured.y + measured.z);
    if (present >= dynamic_range)
        return dim_lift(luma, tone, lift);
    float middle = 0.5 * (measured.x + measured.w);
    float half_wanted = dynamic_range / 510.0;
    float moved = clamp(middle, half_wanted, 1.0 - half_wanted);
    float gain = dynamic_range / present;
    return dim_lift(clamp((luma - middle) * gain + moved, 0.0, 1.0), (tone - middle) * gain + moved, lift);
}
