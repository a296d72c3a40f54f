// Chroma at a pixel, interpolated linearly between the samples around it.
vec2 IMAGE_between(ivec2 at, ivec2 step, vec2 siting) {
    vec2 position = (vec2(at) - siting) / vec2(step);
    // An axis without subsampling has one sample per pixel, independent of the siting.
    position = mix(position, vec2(at), equal(step, ivec2(1)));
    vec2 below = floor(position);
    vec2 part = position - below;
    ivec2 first = ivec2(below);
    vec2 upper = mix(IMAGE_at(first), IMAGE_at(first + ivec2(1, 0)), part.x);
    vec2 lower = mix(IMAGE_at(first + ivec2(0, 1)), IMAGE_at(first + ivec2(1, 1)), part.x);
    return mix(upper, lower, part.y);
}
