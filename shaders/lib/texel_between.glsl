// A texture between its texels, linear; the border is repeated.
vec4 texel_between(sampler2D image, vec2 place, ivec2 last) {
    place = clamp(place, vec2(0.0), vec2(last));
    ivec2 low = ivec2(place), high = min(low + 1, last);
    vec2 part = place - vec2(low);
    vec4 above = mix(texelFetch(image, low, 0), texelFetch(image, ivec2(high.x, low.y), 0), part.x);
    vec4 below = mix(texelFetch(image, ivec2(low.x, high.y), 0), texelFetch(image, high, 0), part.x);
    return mix(above, below, part.y);
}
