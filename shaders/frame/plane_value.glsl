#define IMAGE_decoded(texel) (floor((texel) * IMAGE_top + 0.5) * IMAGE_gain + IMAGE_offset)

// Luma or RGB in a plane of the source. A normalized texture returns code / top, whose rounding would affect
// codes at the border between two tones, so the integer code is restored first.
VALUE IMAGE_at(ivec2 at) {
    ivec2 inside = clamp(at, ivec2(0), IMAGE_last) - IMAGE_origin;
    return IMAGE_decoded(texelFetch(IMAGE, inside, 0).CHANNELS);
}
