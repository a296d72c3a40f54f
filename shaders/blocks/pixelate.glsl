#include "lib/cell_along.glsl"

// The mean over each row of a square.
channels pixelate_across(ivec2 at, float size, ivec2 page) {
    return cell_along(at, ivec2(1, 0), int(size + 0.5), page);
}

// The mean of the row means over the square.
channels pixelate(ivec2 at, float size, ivec2 page) {
    return cell_along(at, ivec2(0, 1), int(size + 0.5), page);
}
