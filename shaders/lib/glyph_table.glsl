// Width and height of a cell in whole pixels, in the ratio 3 to 5; the width is rounded first, to two equal halves.
ivec2 glyph_cell(float width) {
    int whole = 2 * int(0.5 * width + 0.5);
    return ivec2(whole, (10 * whole + 3) / 6);
}

// The glyph of the most similar tone and shape, for the lumas of the six zones of a cell; the first if two are equal.
// The table holds the glyphs side by side, with a width of 3/5 of the height; its last six rows hold the coverage of
// the zones of each glyph.
int glyph_number(float lumas[6], sampler2DArray alphabet, ivec2 alphabet_size) {
    int height = alphabet_size.y - 6, count = 5 * alphabet_size.x / (3 * height), number = 0;
    float tone = 0.0, least = 1e9;
    for (int zone = 0; zone < 6; zone++)
        tone += lumas[zone];
    tone /= 6.0;
    for (int glyph = 0; glyph < count; glyph++) {
        float cover = 0.0, likeness = 0.0;
        for (int zone = 0; zone < 6; zone++) {
            float covered = texelFetch(alphabet, ivec3(glyph, height + zone, 0), 0).r;
            cover += covered;
            likeness += (lumas[zone] - tone) * covered;
        }
        float change = tone - cover / 6.0, difference = 6.0 * change * change - likeness;
        if (difference < least - 1e-4) {
            least = difference;
            number = glyph;
        }
    }
    return number;
}

// The mean of a glyph over a pixel of a cell.
float glyph_cover(ivec2 pixel, ivec2 cell, int number, sampler2DArray alphabet, ivec2 alphabet_size) {
    ivec2 glyph = ivec2((alphabet_size.y - 6) * 3 / 5, alphabet_size.y - 6);
    vec2 scale = vec2(glyph) / vec2(cell), first = vec2(pixel) * scale, last = first + scale;
    float sum = 0.0;
    for (int row = int(first.y); row < min(int(ceil(last.y)), glyph.y); row++) {
        for (int column = int(first.x); column < min(int(ceil(last.x)), glyph.x); column++) {
            vec2 corner = vec2(column, row), shared_part = min(last, corner + 1.0) - max(first, corner);
            float share = max(shared_part.x, 0.0) * max(shared_part.y, 0.0);
            sum += share * texelFetch(alphabet, ivec3(number * glyph.x + column, row, 0), 0).r;
        }
    }
    return sum / (scale.x * scale.y);
}
