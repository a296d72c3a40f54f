#include "lib/lattice_position.glsl"
#include "lib/sine_of_turns.glsl"

// Coverage of a pixel by parallel strokes along a unit direction, in steps of 1/255. Each stroke has its own
// variation in position and width. Width, sway and shift are in spacings.
float stroke_cover(ivec2 at, vec2 direction, float shift, float spacing, float width, float wobble) {
    ivec2 coarse = ivec2(floor(direction.yx * 512.0 + 0.5));
    vec2 across = lattice_position(at, coarse, direction.yx - vec2(coarse) / 512.0, spacing);
    float side = across.y + shift, passed = floor(side);
    float stroke = across.x + passed;
    float along = dot(vec2(at) + 0.5, vec2(direction.x, -direction.y)) / spacing;
    // Rates in turns: 0.31, 0.83 and 0.53 radians for each spacing along; 1, 1.7 and 2.3 times 2.399 for
    // each stroke, whose few leading bits are multiplied exactly.
    vec3 turns = fract(stroke * vec3(0.3818359375, 0.6494140625, 0.8779296875));
    turns += stroke * vec3(-0.00002322902, -0.00033245809, 0.000239542);
    vec3 waves = sine_of_turns(turns + along * vec3(0.0493380324, 0.1320986028, 0.0843521199));
    float middle = 0.5 + 0.09 * wobble * (waves.x + 0.6 * waves.y);
    float half_width = 0.5 * width * (1.0 + 0.35 * wobble * waves.z);
    float cover = (half_width - abs(side - passed - middle)) * spacing + 0.5;
    cover = clamp(cover, 0.0, min(2.0 * half_width * spacing, 1.0));
    return floor(cover * 255.0 + 0.5) / 255.0;
}
