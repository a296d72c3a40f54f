#include "lib/drawing_at.glsl"
#include "lib/octave_of_noise.glsl"

// Moves one channel, the chroma or the whole picture, interpolated linearly; rows sway at random.
vec3 shift(ivec2 at, vec3 weights, uint moment, int plate, float x, float y, float jitter, int rate) {
    int lattice = drawing_at(moment, rate) * 16 + 15;
    float wave = octave_of_noise(vec2(0.0, (float(at.y) + 0.5) / max(3.0 * jitter, 1.0)), lattice);
    vec2 from = -vec2(x + 2.0 * jitter * wave, y), part = from - floor(from);
    ivec2 low = at + ivec2(floor(from));
    vec3 above = mix(picture_at(low), picture_at(low + ivec2(1, 0)), part.x);
    vec3 below = mix(picture_at(low + ivec2(0, 1)), picture_at(low + 1), part.x);
    vec3 own = picture_at(at), moved = mix(above, below, part.y);
    if (plate == shift_plate_chroma)
        moved += dot(weights, own - moved);
    else if (plate != shift_plate_all)
        moved = mix(own, moved, vec3(plate == shift_plate_red, plate == shift_plate_green, plate == shift_plate_blue));
    return clamp(moved, 0.0, 1.0);
}
