#include "lib/screen_cut.glsl"

// How much of a pixel a dot covers: `part` is where in its cell it lies, `share` what of the cell is inked.
float screen_cover(vec2 part, float share, float cell) {
    vec2 s = abs(2.0 * part - 1.0);
    float height = 1.0 - 0.5 * dot(s * s, 3.0 - 2.0 * s);
    // Divided by its slope the height is a distance in pixels, so that every edge is one pixel soft.
    float slope = max(6.0 * length(s * (1.0 - s)), 0.5);
    return clamp((height - screen_cut(share, 1.0 / cell)) * cell / slope + 0.5, 0.0, 1.0);
}
