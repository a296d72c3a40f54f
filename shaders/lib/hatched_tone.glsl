#include "lib/soft_step.glsl"
#include "lib/stroke_cover.glsl"
#include "lib/tone_position.glsl"
#include "lib/unit_direction.glsl"

// Black strokes on white: set n is drawn where luma is below its border. The sets are rotated by 0, 90, 45 and
// 135 degrees, the first `turns` of these; further sets repeat them, halfway between the existing strokes.
float hatched_tone(
    float luma, ivec2 at, int levels, float spacing, float width, float angle, int turns, float wobble,
    float softness) {
    vec2 straight = unit_direction(angle);
    vec2 diagonal = vec2(straight.x - straight.y, straight.x + straight.y) * 0.7071067812;
    float level = tone_position(luma, levels), tone = 1.0;
    for (int number = 0; number < levels - 1; number++) {
        float shown = soft_step(float(levels - 1 - number) - level, softness);
        if (shown <= 0.0)
            break; // all further sets are for darker tones
        int turn = number % turns;
        vec2 direction = turn < 2 ? straight : diagonal;
        direction = turn % 2 == 0 ? direction : vec2(-direction.y, direction.x);
        float shift = 0.5 * float(number / turns) + 0.37 * float(turn);
        tone *= 1.0 - shown * stroke_cover(at, direction, shift, spacing, width, wobble);
    }
    return tone;
}
