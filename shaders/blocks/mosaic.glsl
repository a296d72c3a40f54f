#include "lib/white_noise.glsl"

// The middle of a tile, in pixels of the page.
vec2 middle_of_tile(ivec2 tile, float size, float irregularity) {
    ivec2 point = ivec2(3 * tile.x, tile.y);
    vec2 random = vec2(white_noise(point), white_noise(point + ivec2(1, 0)));
    return (vec2(tile) + 0.5 + irregularity * (random - 0.5)) * size;
}

// Tiles of one colour each: the Voronoi cells of a random point in each square of a grid. Worley 1996.
vec3 mosaic(ivec2 at, ivec2 page, float size, float irregularity, float gap, vec3 gap_color, float variation) {
    vec2 here = vec2(at) + 0.5, own = here;
    ivec2 square = ivec2(here / size), nearest = square, last = ivec2(ceil(vec2(page) / size)) + 1;
    float least = 1e9, border = 1e9;
    for (int row = -1; row <= 1; row++) {
        for (int column = -1; column <= 1; column++) {
            vec2 middle = middle_of_tile(square + ivec2(column, row), size, irregularity);
            float squared = dot(middle - here, middle - here);
            if (squared < least) {
                least = squared;
                own = middle;
                nearest = square + ivec2(column, row);
            }
        }
    }
    for (int row = max(nearest.y - 2, -2); row <= min(nearest.y + 2, last.y); row++) {
        for (int column = max(nearest.x - 2, -2); column <= min(nearest.x + 2, last.x); column++) {
            ivec2 tile = ivec2(column, row);
            vec2 away = middle_of_tile(tile, size, irregularity) - own;
            if (tile != nearest)
                border = min(border, dot(own + 0.5 * away - here, away) / max(length(away), 1e-6));
        }
    }
    float change = variation * (white_noise(ivec2(3 * nearest.x + 2, nearest.y)) - 0.5);
    vec3 color = clamp(picture_at(ivec2(floor(own))) + change, 0.0, 1.0);
    return mix(color, gap_color, clamp(gap / 2.0 - border + 0.5, 0.0, min(1.0, gap)));
}
