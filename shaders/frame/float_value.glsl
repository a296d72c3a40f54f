#define IMAGE_decoded(texel) (texel)

// Luma or RGB in a float32 plane of the source.
VALUE IMAGE_at(ivec2 at) {
    return IMAGE_decoded(texelFetch(IMAGE, clamp(at, ivec2(0), IMAGE_last) - IMAGE_origin, 0).CHANNELS);
}
