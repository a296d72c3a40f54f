// How many whole spacings lie between the page's corner and the middle of a pixel along a unit direction, and
// the part of one beyond them (0..1). The direction is the sum of a coarse one, in 512ths, and the fine rest.
// Good to 0.0001 px on pages up to 16384 px.
vec2 lattice_position(ivec2 at, ivec2 coarse, vec2 fine, float spacing) {
    // Whole numbers of 1024ths, because float32 has too few bits, and compilers reorder sums of floats.
    ivec2 passed = (2 * at + 1) * coarse;
    int coarse_spacing = int(spacing * 32.0) * 32;
    float whole = floor(float(passed.x + passed.y) / 1024.0 / spacing);
    float rest = float(passed.x + passed.y - int(whole) * coarse_spacing) / 1024.0;
    rest += dot(vec2(at) + 0.5, fine) - whole * (spacing - float(coarse_spacing) / 1024.0);
    // The lift lets rounding not decide where a pixel lies just between two spacings.
    float carried = floor((rest + 1e-4) / spacing);
    return vec2(whole + carried, rest / spacing - carried);
}
