// RGB of a gray pixel.
vec3 rgb_from_gray(float luma) {
    return vec3(luma);
}
