// RGB of luma, blue and red difference. ITU-T H.273, section 8.3.
vec3 rgb_from_yuv(float luma, vec2 chroma, mat3 to_rgb) {
    return to_rgb * vec3(luma, chroma);
}
