#include "lib/octave_of_noise.glsl"

// Noise of a channel, about 0: points, or octaves of half the size and weight of the one before.
float channel_of_noise(ivec2 at, int channel, int kind, vec2 size) {
    int start = channel * 5, octaves = kind == noise_kind_clouds ? 4 : 1;
    if (kind == noise_kind_points)
        return white_noise(at / ivec2(size + 0.5) + start * 10007) - 0.5;
    float sum = 0.0, part = 1.0;
    for (int octave = 0; octave < octaves; octave++) {
        sum += part * octave_of_noise((vec2(at) + 0.5) / (size * part), start + octave);
        part *= 0.5;
    }
    return sum * 0.5 / (1.0 - part);
}

// Random values added that are fixed to the page.
channels noise(channels picture, ivec2 at, int kind, float size, float stretch, float amount, bool colored) {
    vec2 sides = vec2(size * stretch, size);
    vec3 added = vec3(channel_of_noise(at, 0, kind, sides));
    if (colored)
        added.gb = vec2(channel_of_noise(at, 1, kind, sides), channel_of_noise(at, 2, kind, sides));
    return clamp(picture + amount * channels(added), 0.0, 1.0);
}
