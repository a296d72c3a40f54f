// Width and height of a cell in whole pixels, in the ratio 3 to 5; the width is rounded first.
ivec2 glyph_cell(float width) {
    int whole = int(width + 0.5);
    return ivec2(whole, (10 * whole + 3) / 6);
}

// The glyph for a tone. The table holds the glyphs side by side, with a width of 3/5 of the height; its last row holds
// the lowest tone of each glyph.
int glyph_number(float tone, sampler2DArray alphabet, ivec2 alphabet_size) {
    int last = alphabet_size.y - 1, count = 5 * alphabet_size.x / (3 * last), number = 0;
    while (number + 1 < count && texelFetch(alphabet, ivec3(number + 1, last, 0), 0).r <= tone + 5e-5)
        number++;
    return number;
}

// The mean of a glyph over a pixel of a cell.
float glyph_cover(ivec2 pixel, ivec2 cell, int number, sampler2DArray alphabet, ivec2 alphabet_size) {
    ivec2 glyph = ivec2((alphabet_size.y - 1) * 3 / 5, alphabet_size.y - 1);
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
