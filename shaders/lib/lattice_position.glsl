// The distance from the page's corner to the centre of a pixel along a unit direction, as whole spacings and a
// fraction (0..1). The direction is the sum of a coarse one, in 512ths, and a fine rest. Accurate to 0.0001 px on
// pages of up to 16384 px.
vec2 lattice_position(ivec2 at, ivec2 coarse, vec2 fine, float spacing) {
    // Integers in 1024ths, as float32 has too few bits and compilers reorder sums of floats.
    ivec2 passed = (2 * at + 1) * coarse;
    int coarse_spacing = int(spacing * 32.0) * 32;
    float whole = floor(float(passed.x + passed.y) / 1024.0 / spacing);
    float rest = float(passed.x + passed.y - int(whole) * coarse_spacing) / 1024.0;
    rest += dot(vec2(at) + 0.5, fine) - whole * (spacing - float(coarse_spacing) / 1024.0);
    // The lift keeps rounding from deciding when a pixel is exactly between two spacings.
    float carried = floor((rest + 1e-4) / spacing);
    return vec2(whole + carried, rest / spacing - carried);
}
