#include "lib/cell_along.glsl"
#include "lib/glyph_table.glsl"

// The mean over each row of a cell.
channels glyphs_across(ivec2 at, float cell, ivec2 page) {
    return cell_along(at, ivec2(1, 0), glyph_cell(cell).x, page);
}

// A glyph in each cell of the page; brighter cells get glyphs that cover more.
channels glyphs(
    ivec2 at, ivec2 page, vec3 weights, float cell, bool invert, sampler2DArray alphabet, ivec2 alphabet_size) {
    channels mean = clamp(cell_along(at, ivec2(0, 1), glyph_cell(cell).y, page), 0.0, 1.0);
    mean = invert ? 1.0 - mean : mean;
    vec3 color = vec3(mean);
    ivec2 cell_size = glyph_cell(cell);
    int number = glyph_number(dot(color, weights), alphabet, alphabet_size);
    float shown = glyph_cover(at % cell_size, cell_size, number, alphabet, alphabet_size);
    channels drawn = shown * mean / max(max(color.r, max(color.g, color.b)), 0.1);
    return invert ? 1.0 - drawn : drawn;
}
