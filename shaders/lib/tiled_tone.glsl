#include "lib/soft_step.glsl"
#include "lib/tone_position.glsl"

// Tiles that repeat over the page, darkest first; each covers the darker ones where luma is above its
// border.
float tiled_tone(
    float luma, ivec2 at, float softness, sampler2DArray tiles, ivec2 tiles_sizes[32], int tiles_count) {
    float level = tone_position(luma, tiles_count);
    float tone = texelFetch(tiles, ivec3(at % tiles_sizes[0], 0), 0).r;
    for (int number = 1; number < tiles_count; number++) {
        float shown = soft_step(level - float(number), softness);
        if (shown <= 0.0)
            break; // all further tiles are for lighter tones
        tone = mix(tone, texelFetch(tiles, ivec3(at % tiles_sizes[number], number), 0).r, shown);
    }
    return tone;
}
