#include "lib/drawing_at.glsl"
#include "lib/octave_of_noise.glsl"

// Noise of a lattice, with a mean of 0: points, or octaves with half the size and weight of the previous one.
float lattice_noise(int start, ivec2 at, int kind, vec2 size) {
    int octaves = kind == noise_kind_clouds ? 4 : 1;
    if (kind == noise_kind_points)
        return white_noise(at / ivec2(size + 0.5) + start * APART) - 0.5;
    float sum = 0.0, part = 1.0;
    for (int octave = 0; octave < octaves; octave++) {
        sum += part * octave_of_noise((vec2(at) + 0.5) / (size * part), start + octave);
        part *= 0.5;
    }
    return sum * 0.5 / (1.0 - part);
}

// Adds random values that are fixed to the page and change only at `rate`.
channels noise(
    channels picture, ivec2 at, uint moment, int kind, float size, float stretch, float amount, bool colored,
    int rate) {
    vec2 sides = vec2(size * stretch, size);
    int start = drawing_at(moment, rate) * 16;
    vec3 added = vec3(lattice_noise(start, at, kind, sides));
    if (colored)
        added.gb = vec2(lattice_noise(start + 5, at, kind, sides), lattice_noise(start + 10, at, kind, sides));
    return clamp(picture + amount * channels(added), 0.0, 1.0);
}
