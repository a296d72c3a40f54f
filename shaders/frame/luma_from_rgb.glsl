// Luma of RGB. ITU-T H.273, section 8.3.
float luma_from_rgb(vec3 color, mat3 from_rgb) {
    return (from_rgb * color).x;
}
