// Luma in a working texture of floats, or of two half floats from `halves`. The border is repeated.
float IMAGE_at(ivec2 at) {
    ivec2 inside = clamp(at, ivec2(0), IMAGE_last) - IMAGE_origin;
    vec2 parts = texelFetch(IMAGE, inside, 0).rg;
    return parts.r + parts.g;
}
