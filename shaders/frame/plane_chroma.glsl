// Chroma in two planes of the source, at one of their samples.
vec2 IMAGE_at(ivec2 at) {
    ivec2 inside = clamp(at, ivec2(0), IMAGE_last) - IMAGE_origin;
    vec2 chroma = vec2(texelFetch(IMAGE, inside, 0).r, texelFetch(IMAGE_red, inside, 0).r);
    return chroma * IMAGE_gain + IMAGE_offset;
}
