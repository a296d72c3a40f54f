// The flow at a pixel of a page, linear between the points of its coarse grid.
vec2 flow_at(ivec2 at, ivec2 size, sampler2D flow) {
    ivec2 grid = textureSize(flow, 0), last = grid - 1;
    vec2 place = (vec2(at) + 0.5) * vec2(grid) / vec2(size) - 0.5;
    ivec2 low = clamp(ivec2(floor(place)), ivec2(0), last), high = clamp(ivec2(floor(place)) + 1, ivec2(0), last);
    vec2 part = place - floor(place);
    vec2 above = mix(texelFetch(flow, low, 0).rg, texelFetch(flow, ivec2(high.x, low.y), 0).rg, part.x);
    vec2 below = mix(texelFetch(flow, ivec2(low.x, high.y), 0).rg, texelFetch(flow, high, 0).rg, part.x);
    return mix(above, below, part.y);
}
