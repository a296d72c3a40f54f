// Chroma computed by the group; the page's border is repeated.
shared vec2 tile_chroma[AREA.x * AREA.y];
ivec2 tile_corner;

vec2 chroma_at(ivec2 at) {
    ivec2 inside = clamp(at, ivec2(0), page - 1) - tile_corner;
    return tile_chroma[inside.y * AREA.x + inside.x];
}

#include "frame/shrunk_chroma.glsl"

// Each group computes each pixel of a tile, and of the margin that its chroma samples cover, once, and averages its
// chroma from shared memory.
void main() {
    ivec2 start = ivec2(gl_WorkGroupID.xy) * TILE;
    tile_corner = origin + start - RIM_BEFORE;
    ivec2 first = max(tile_corner, ivec2(0)), rim_after = AREA - TILE - RIM_BEFORE;
    ivec2 end = min(min(tile_corner + AREA, origin + size + rim_after), page);
    prepare(first, end - first);
    for (int number = int(gl_LocalInvocationIndex); number < AREA.x * AREA.y; number += INVOCATIONS) {
        ivec2 inside = ivec2(number % AREA.x, number / AREA.x);
        ivec2 at = tile_corner + inside;
        ivec2 place = at - origin;
        bool own = all(greaterThanEqual(inside, RIM_BEFORE)) && all(lessThan(inside, RIM_BEFORE + TILE));
        if (all(greaterThanEqual(at, first)) && all(lessThan(at, end))) {
            tile_chroma[number] = evaluate(at, place, own && all(lessThan(place, size)));
        }
    }
    barrier();
    ivec2 samples = TILE / STEP;
    for (int number = int(gl_LocalInvocationIndex); number < samples.x * samples.y; number += INVOCATIONS) {
        ivec2 sample_place = start / STEP + ivec2(number % samples.x, number / samples.x);
        if (all(lessThan(sample_place * STEP, size))) {
            store_chroma(sample_place, shrunk_chroma(origin / STEP + sample_place, STEP, SITING));
        }
    }
}
