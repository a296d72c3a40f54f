#include "lib/white_noise.glsl"

// Weight of the squared difference of two colours next to the squared distance in sizes of a tile.
const float COLOR_WEIGHT = 30.0;

// The middle of a tile that has moved by some squares, in pixels of the page.
vec2 middle_of_tile(ivec2 tile, vec2 moved, float size, float irregularity) {
    vec2 passed = floor(moved + 0.5);
    ivec2 point = ivec2(3 * (tile.x - int(passed.x)), tile.y - int(passed.y));
    vec2 random = vec2(white_noise(point), white_noise(point + ivec2(1, 0)));
    return (vec2(tile) + 0.5 + (irregularity * (random - 0.5) + (moved - passed))) * size;
}

// The tile of a pixel: the one around it that is nearest in place and colour.
ivec2 tile_along_edges(ivec2 at, ivec2 page, float size, float irregularity, float edges) {
    vec2 here = vec2(at) + 0.5;
    vec3 color = clamp(picture_at(at), 0.0, 1.0);
    ivec2 square = ivec2(here / size), nearest = square;
    vec2 moved = drift_of(square, size, page), offset = moved - floor(moved + 0.5);
    // Where tiles have moved by half a square, their squares have, too.
    int middle_row = offset.y == 0.0 ? square.y : int(floor(here.y / size - offset.y));
    int left = square.x - (offset.x > 0.0 ? 2 : 1), right = square.x + (offset.x < 0.0 ? 2 : 1);
    float least = 1e9, scale = 1.0 / (size * size);
    for (int row = middle_row - 1; row <= middle_row + 1; row++) {
        for (int column = left; column <= right; column++) {
            ivec2 tile = ivec2(column, row);
            vec2 middle = middle_of_tile(tile, drift_of(tile, size, page), size, irregularity), away = middle - here;
            vec3 difference = color - clamp(picture_at(ivec2(floor(middle))), 0.0, 1.0);
            float far = scale * dot(away, away) + edges * COLOR_WEIGHT * dot(difference, difference);
            if (far < least) {
                least = far;
                nearest = tile;
            }
        }
    }
    return nearest;
}

// The share of a pixel that is gap, as a pixel of another tile is near.
float gap_along_edges(ivec2 at, ivec2 page, ivec2 own, float size, float irregularity, float gap, float edges) {
    int reach = int(ceil(gap / 2.0));
    float cover = 0.0;
    for (int row = -reach; row <= reach; row++) {
        for (int column = -reach; column <= reach; column++) {
            float closer = min(gap / 2.0 + 1.0 - length(vec2(column, row)), min(1.0, gap));
            ivec2 there = clamp(at + ivec2(column, row), ivec2(0), page - 1);
            if (closer > cover && there != at && tile_along_edges(there, page, size, irregularity, edges) != own)
                cover = closer;
        }
    }
    return cover;
}

// Tiles of one colour each: the Voronoi cells of a random point in each square of a grid. Worley 1996.
vec3 mosaic(
    ivec2 at, ivec2 page, float size, float irregularity, float gap, vec3 gap_color, float variation, float edges) {
    vec2 here = vec2(at) + 0.5, own = here;
    ivec2 square = ivec2(here / size), nearest = square, last = ivec2(ceil(vec2(page) / size)) + 1;
    vec2 moved = vec2(0.0);
    float least = 1e9, border = 1e9, cover = 0.0;
    if (edges > 0.0) {
        nearest = tile_along_edges(at, page, size, irregularity, edges);
        moved = drift_of(nearest, size, page);
        own = middle_of_tile(nearest, moved, size, irregularity);
        cover = gap_along_edges(at, page, nearest, size, irregularity, gap, edges);
    } else {
        for (int row = -1; row <= 1; row++) {
            for (int column = -1; column <= 1; column++) {
                vec2 middle = middle_of_tile(square + ivec2(column, row), moved, size, irregularity);
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
                vec2 away = middle_of_tile(tile, moved, size, irregularity) - own;
                if (tile != nearest)
                    border = min(border, dot(own + 0.5 * away - here, away) / max(length(away), 1e-6));
            }
        }
        cover = clamp(gap / 2.0 - border + 0.5, 0.0, min(1.0, gap));
    }
    ivec2 point = nearest - ivec2(floor(moved + 0.5));
    float change = variation * (white_noise(ivec2(3 * point.x + 2, point.y)) - 0.5);
    vec3 color = clamp(picture_at(ivec2(floor(own))) + change, 0.0, 1.0);
    return mix(color, gap_color, cover);
}
