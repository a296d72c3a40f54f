#include "lib/dim_lift.glsl"

// Luma stretched so that the low percentile becomes black and the high one white; a range below
// 8 levels of 255 counts as 8. Paper, section 4.2 D. Pictures without black stay without it, and dim ones are
// brightened.
float equalize(float luma, vec4 measured, float lift) {
    float level = min(2.0 * lift, 1.0) * (clamp(measured.x, 0.04, 0.16) - 0.04);
    float gain = (1.0 - level) / max(measured.w - measured.x, 8.0 / 255.0);
    float middle = (0.5 * (measured.y + measured.z) - measured.x) * gain + level;
    return dim_lift(clamp((luma - measured.x) * gain + level, 0.0, 1.0), middle, lift);
}
