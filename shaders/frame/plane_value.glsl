#define IMAGE_decoded(texel) (floor((texel) * IMAGE_top + 0.5) * IMAGE_gain + IMAGE_offset)

// Luma or RGB in a plane of the source. A normalized texture gives code / top, whose rounding would move
// codes that lie just upon the border of a tone: the code itself is taken back first.
VALUE IMAGE_at(ivec2 at) {
    ivec2 inside = clamp(at, ivec2(0), IMAGE_last) - IMAGE_origin;
    return IMAGE_decoded(texelFetch(IMAGE, inside, 0).CHANNELS);
}
