#include "lib/lattice_position.glsl"

// The height above which a halftone screen has this share of its area: the polynomial of `_cut` in the block's
// Python module. `per_pixel` is the size of a pixel relative to a cell.
float screen_cut(float share, float per_pixel) {
    float x = 1.0 - 2.0 * share;
    float x2 = x * x, x4 = x2 * x2;
    float odd = 0.25987756 + 0.46864727 * x2 - 0.43836827 * x4 + 0.20984343 * x4 * x2;
    float lift = per_pixel * (1.5 * per_pixel + 0.25);
    return 0.5 + x * (odd + lift * x2 * x4 * x4 * x4);
}

// Coverage of a pixel by a dot: `part` is its position in the cell, `share` the inked share of the cell.
float screen_cover(vec2 part, float share, float cell) {
    vec2 s = abs(2.0 * part - 1.0);
    float height = 1.0 - 0.5 * dot(s * s, 3.0 - 2.0 * s);
    // Divided by its slope, the height is a distance in pixels, so that edges are anti-aliased over one pixel.
    float slope = max(6.0 * length(s * (1.0 - s)), 0.5);
    return clamp((height - screen_cut(share, 1.0 / cell)) * cell / slope + 0.5, 0.0, 1.0);
}

// The share of a cell that an ink covers to print a colour: 0 cyan, 1 magenta, 2 yellow, 3 black, which
// replaces the common part of the other three.
float ink_share(vec3 color, int ink, float black) {
    float key = black * (1.0 - max(color.r, max(color.g, color.b)));
    vec3 others = (1.0 - color - key) / max(1.0 - key, 1e-3);
    return clamp(vec4(others, key)[ink], 0.0, 1.0);
}

// Coverage of a pixel by one ink on a screen rotated to a unit direction, given as a coarse part in 512ths and a
// fine rest. The picture holds means over a cell; `amount` multiplies the ink and `gain` is the dot gain of
// midtones.
float ink_cover(
    ivec2 at, int ink, ivec2 coarse, vec2 fine, float cell, float amount, float gain, float black) {
    ivec2 turned = ivec2(-coarse.y, coarse.x);
    vec2 turned_fine = vec2(-fine.y, fine.x);
    vec2 part = vec2(
        lattice_position(at, coarse, fine, cell).y, lattice_position(at, turned, turned_fine, cell).y);
    vec2 to_middle = (0.5 - part) * cell;
    vec2 along = vec2(coarse) / 512.0 + fine;
    vec2 shift = to_middle.x * along + to_middle.y * vec2(-along.y, along.x);
    // The lift keeps rounding from deciding when the middle of a cell is exactly between two pixels.
    vec3 color = picture_at(at + ivec2(floor(shift + 0.50005)));
    float share = min(ink_share(color, ink, black) * amount, 1.0);
    share = min(share + 4.0 * gain * share * (1.0 - share), 1.0);
    return screen_cover(part, share, cell);
}
