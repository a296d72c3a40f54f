// How many whole spacings lie between the page's corner and a position along a unit direction, and the
// part of one beyond them (0..1). Good to 0.001 px on pages up to 16384 px, where float32 alone is not.
vec2 lattice_position(vec2 position, vec2 direction, float spacing) {
    // The coarse direction and the coarse spacing have so few bits that their products are exact.
    vec2 coarse = floor(direction * 512.0 + 0.5) / 512.0;
    float coarse_spacing = floor(spacing * 32.0) / 32.0;
    float passed = dot(position, coarse);
    float whole = floor(passed / spacing);
    float rest = passed - whole * coarse_spacing;
    rest += dot(position, direction - coarse) - whole * (spacing - coarse_spacing);
    // The lift lets rounding not decide where a pixel lies just between two spacings.
    float carried = floor((rest + 1e-4) / spacing);
    return vec2(whole + carried, rest / spacing - carried);
}
