// Points between the parts of the lattice for two drawings or two octaves.
const int APART = 10007;

// A uniform random number 0..1 for a point of an infinite lattice.
float white_noise(ivec2 point) {
    uint bits = uint(point.x) * 0x9E3779B1u ^ uint(point.y) * 0x85EBCA77u;
    bits = (bits ^ bits >> 15u) * 0x2C1B3C6Du;
    bits = (bits ^ bits >> 12u) * 0x297A2D39u;
    return float((bits ^ bits >> 15u) >> 8u) / 16777216.0;
}

// The noise between the points of its lattice, some rows further down.
float white_noise_between(vec2 place, int rows) {
    ivec2 low = ivec2(floor(place));
    vec2 part = place - vec2(low);
    low.y += rows;
    float above = mix(white_noise(low), white_noise(low + ivec2(1, 0)), part.x);
    float below = mix(white_noise(low + ivec2(0, 1)), white_noise(low + 1), part.x);
    return mix(above, below, part.y);
}
