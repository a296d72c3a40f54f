#include "lib/lattice_position.glsl"
#include "lib/ink_share.glsl"
#include "lib/screen_cover.glsl"

// How much of a pixel one ink covers on a screen that is turned to a unit direction, given in 512ths and the
// fine rest. The picture holds means over a cell; `amount` multiplies the ink and `gain` spreads its middle
// tones.
float ink_cover(
    ivec2 at, int ink, ivec2 coarse, vec2 fine, float cell, float amount, float gain, float black) {
    ivec2 turned = ivec2(-coarse.y, coarse.x);
    vec2 turned_fine = vec2(-fine.y, fine.x);
    vec2 part = vec2(
        lattice_position(at, coarse, fine, cell).y, lattice_position(at, turned, turned_fine, cell).y);
    vec2 to_middle = (0.5 - part) * cell;
    vec2 along = vec2(coarse) / 512.0 + fine;
    vec2 shift = to_middle.x * along + to_middle.y * vec2(-along.y, along.x);
    // The lift lets rounding not decide where a cell's middle lies just between two pixels.
    vec3 color = picture_at(at + ivec2(floor(shift + 0.50005)));
    float share = min(ink_share(color, ink, black) * amount, 1.0);
    share = min(share + 4.0 * gain * share * (1.0 - share), 1.0);
    return screen_cover(part, share, cell);
}
