#include "lib/hatched_tone.glsl"
#include "lib/tiled_tone.glsl"

// Tones as black hatching on white, with more strokes in darker areas; or as tiles. Paper, section 4.2 B.
// `layout` is a keyword of GLSL, hence the underscore.
float pattern(
    float luma, ivec2 at, int levels, float spacing, float width, float angle, int layout_, float wobble,
    float softness, sampler2DArray tiles, ivec2 tiles_sizes[32], int tiles_count) {
    if (tiles_count > 0)
        return tiled_tone(luma, at, softness, tiles, tiles_sizes, tiles_count);
    int turns = layout_ == pattern_layout_cross ? 4 : layout_ == pattern_layout_weave ? 2 : 1;
    return hatched_tone(luma, at, levels, spacing, width, angle, turns, wobble, softness);
}
