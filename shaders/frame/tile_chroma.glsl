// Chroma that the group has computed; beyond the page's border the border is repeated.
shared vec2 tile_chroma[AREA.x * AREA.y];
ivec2 tile_corner;

vec2 chroma_at(ivec2 at) {
    ivec2 inside = clamp(at, ivec2(0), page - 1) - tile_corner;
    return tile_chroma[inside.y * AREA.x + inside.x];
}
