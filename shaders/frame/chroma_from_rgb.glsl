// Blue and red difference of RGB. ITU-T H.273, section 8.3.
vec2 chroma_from_rgb(vec3 color, mat3 from_rgb) {
    return (from_rgb * color).yz;
}
