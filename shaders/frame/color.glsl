#include "lib/clipped_color.glsl"

// RGB after a colour matrix: the weights of the channels, and a number to add, for each channel.
vec3 color_matrix(vec3 color, vec4 red, vec4 green, vec4 blue) {
    vec4 extended = vec4(color, 1.0);
    return clipped_color(vec3(dot(red, extended), dot(green, extended), dot(blue, extended)), color);
}

// Luma of RGB. ITU-T H.273, section 8.3.
float luma_from_rgb(vec3 color, mat3 from_rgb) {
    return (from_rgb * color).x;
}

// Blue and red difference of RGB. ITU-T H.273, section 8.3.
vec2 chroma_from_rgb(vec3 color, mat3 from_rgb) {
    return (from_rgb * color).yz;
}

// RGB of luma, blue and red difference. ITU-T H.273, section 8.3.
vec3 rgb_from_yuv(float luma, vec2 chroma, mat3 to_rgb) {
    return to_rgb * vec3(luma, chroma);
}

// RGB of a gray pixel.
vec3 rgb_from_gray(float luma) {
    return vec3(luma);
}

// Chroma that is already on the grid of the result: only the codes change.
vec2 same_chroma(vec2 chroma) {
    return chroma;
}
