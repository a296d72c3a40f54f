#include "lib/lattice_position.glsl"
#include "lib/unit_direction.glsl"

// Tones as black lines on white, wider in darker areas, and displaced by the luma of a form.
float line_screen(
    float luma, ivec2 at, float form, float spacing, float angle, float bend, float least, float most) {
    vec2 direction = unit_direction(angle);
    ivec2 coarse = ivec2(floor(direction.yx * 512.0 + 0.5));
    float turns = lattice_position(at, coarse, direction.yx - vec2(coarse) / 512.0, spacing).y;
    turns += bend / spacing * form;
    float width = least + (most - least) * (1.0 - clamp(luma, 0.0, 1.0));
    float beside = abs(turns - floor(turns) - 0.5);
    float cover = (0.5 * width * (1.0 + 1.0 / spacing) - beside) * spacing + 0.5;
    return 1.0 - clamp(cover, 0.0, min(width * spacing, 1.0));
}
