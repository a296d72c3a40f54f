// Size of a plane, its maximum code, the weight of the previous plane, and the weights of luma.
uniform sampler2D plane;
uniform ivec2 size;
uniform float white;
uniform float blend_weight;
uniform sampler2D guide;
uniform vec2 luma_step;

// Number of samples of a row with the same displacement.
uniform int segment;

// The value of a grid over the page for the segment of a sample.
vec2 in_segment(ivec2 at, sampler2D grid) {
    return texelFetch(grid, ivec2(at.x / segment, (2 * at.y + 1) * textureSize(grid, 0).y / (2 * size.y)), 0).rg;
}

// A texture, interpolated bilinearly; the border is repeated.
vec4 texel_between(sampler2D image, vec2 place, ivec2 last) {
    place = clamp(place, vec2(0.0), vec2(last));
    ivec2 low = clamp(ivec2(place), ivec2(0), last), high = min(low + 1, last);
    vec2 part = place - vec2(low);
    vec4 above = mix(texelFetch(image, low, 0), texelFetch(image, ivec2(high.x, low.y), 0), part.x);
    vec4 below = mix(texelFetch(image, ivec2(low.x, high.y), 0), texelFetch(image, high, 0), part.x);
    return mix(above, below, part.y);
}

// The warped previous plane at a pixel.
vec4 warped_at(sampler2D before, ivec2 at, sampler2D flow) {
    return texel_between(before, vec2(at) + in_segment(at, flow), size - 1);
}

// The blending weight of luma at a sample of a plane.
float luma_weight_at(ivec2 at) {
    return texelFetch(guide, min(at * ivec2(luma_step), textureSize(guide, 0) - 1), 0).r;
}
