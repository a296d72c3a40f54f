#include "lib/box_along.glsl"
#include "lib/halftone_screen.glsl"

// Horizontal pass of the mean over a cell.
vec3 halftone_across(ivec2 at, float cell) {
    return box_along(at, ivec2(1, 0), cell);
}

// Vertical pass on the result.
vec3 halftone_down(ivec2 at, float cell) {
    return box_along(at, ivec2(0, 1), cell);
}

// Dots of cyan, magenta, yellow and black on screens at 15, 75, 0 and 45 degrees. Paper, section 4.2 B.
vec3 halftone(ivec2 at, float cell, float dot, float gain, float black, int inks) {
    ivec2 coarse = ivec2(495, 133); // 512 times the cosine and the sine of 15 degrees
    vec2 fine = vec2(-0.0008710487109, -0.0009465798975);
    float cyan = ink_cover(at, 0, coarse, fine, cell, dot, gain, black);
    float magenta = ink_cover(at, 1, coarse.yx, fine.yx, cell, dot, gain, black);
    float yellow = ink_cover(at, 2, ivec2(512, 0), vec2(0.0), cell, dot, gain, black);
    float key = ink_cover(at, 3, ivec2(362), vec2(0.0000755311865), cell, dot, gain, black);
    // The colour of each ink on white paper.
    bool press = inks == halftone_inks_press;
    vec3 left = mix(vec3(1.0), press ? vec3(0.0, 0.62, 0.88) : vec3(0.0, 1.0, 1.0), cyan);
    left *= mix(vec3(1.0), press ? vec3(0.87, 0.07, 0.5) : vec3(1.0, 0.0, 1.0), magenta);
    left *= mix(vec3(1.0), press ? vec3(1.0, 0.9, 0.08) : vec3(1.0, 1.0, 0.0), yellow);
    return left * mix(vec3(1.0), press ? vec3(0.13, 0.12, 0.13) : vec3(0.0), key);
}
