#include "lib/cell_along.glsl"
#include "lib/glyph_table.glsl"

// The mean over each row of half a cell.
channels glyphs_across(ivec2 at, float cell, ivec2 page) {
    return cell_along(at, ivec2(1, 0), glyph_cell(cell).x / 2, page);
}

// In each cell of the page the glyph whose zones are most similar; brighter cells get glyphs that cover more.
channels glyphs(
    ivec2 at, ivec2 page, vec3 weights, float cell, bool invert, sampler2DArray alphabet, ivec2 alphabet_size) {
    ivec2 cell_size = glyph_cell(cell), first = at / cell_size * cell_size, past = min(first + cell_size, page);
    int side = cell_size.x / 2;
    channels sum = channels(0.0), zones[6];
    float areas[6];
    for (int zone = 0; zone < 6; zone++) {
        int column = first.x + zone % 2 * side;
        int upper = first.y + (zone / 2 * cell_size.y + 2) / 3;
        int lower = min(first.y + ((zone / 2 + 1) * cell_size.y + 2) / 3, past.y);
        zones[zone] = channels(0.0);
        areas[zone] = float(max(lower - upper, 0) * clamp(past.x - column, 0, side));
        if (areas[zone] > 0.0) {
            for (int row = upper; row < lower; row++)
                zones[zone] += picture_at(ivec2(column, row));
            zones[zone] /= float(lower - upper);
            sum += areas[zone] * zones[zone];
        }
    }
    vec2 inside = vec2(past - first);
    channels mean = clamp(sum / (inside.x * inside.y), 0.0, 1.0);
    mean = invert ? 1.0 - mean : mean;
    float lumas[6];
    for (int zone = 0; zone < 6; zone++) {
        channels level = clamp(zones[zone], 0.0, 1.0);
        level = areas[zone] > 0.0 ? (invert ? 1.0 - level : level) : mean;
        lumas[zone] = dot(vec3(level), weights);
    }
    vec3 color = vec3(mean);
    int number = glyph_number(lumas, alphabet, alphabet_size);
    float shown = glyph_cover(at - first, cell_size, number, alphabet, alphabet_size);
    channels drawn = shown * mean / max(max(color.r, max(color.g, color.b)), 0.1);
    return invert ? 1.0 - drawn : drawn;
}
