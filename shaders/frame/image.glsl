#define IMAGE_decoded(texel) ((texel) * IMAGE_span + IMAGE_low)

// A picture in a working texture, or a float32 plane of the source, whose numbers represent
// IMAGE_low .. IMAGE_low + IMAGE_span. The border is repeated.
VALUE IMAGE_at(ivec2 at) {
    ivec2 inside = clamp(at, ivec2(0), IMAGE_last) - IMAGE_origin;
    return IMAGE_decoded(texelFetch(IMAGE, inside, 0).CHANNELS);
}
