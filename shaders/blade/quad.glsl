// Four pixels of a picture with one channel, in the order of textureGather: lower left, lower right, upper
// right, upper left, where `at` is the upper left one.
vec4 quad_at(ivec2 at) {
#ifdef GL_ARB_texture_gather
    // The border of the page is repeated; it is not the edge of the texture.
    if (all(greaterThanEqual(at, ivec2(0))) && all(lessThan(at, IMAGE_last))) {
        vec2 corner = vec2(at - IMAGE_origin + 1) / vec2(textureSize(IMAGE, 0));
        return IMAGE_decoded(textureGather(IMAGE, corner));
    }
#endif
    return vec4(
        IMAGE_at(at + ivec2(0, 1)), IMAGE_at(at + ivec2(1, 1)), IMAGE_at(at + ivec2(1, 0)), IMAGE_at(at));
}
