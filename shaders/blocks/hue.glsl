#include "lib/clipped_color.glsl"

// Rotates all hues in the chroma plane, keeping luma, and adds a tint. Paper, section 4.2 A.
vec3 hue(vec3 picture, vec3 weights, float angle, float red, float green, float blue) {
    float luma = dot(picture, weights);
    vec2 span = 2.0 - 2.0 * weights.br;
    vec2 chroma = (picture.br - luma) / span;
    float cosine = cos(radians(angle)), sine = sin(radians(angle));
    vec2 above = span * vec2(cosine * chroma.x - sine * chroma.y, sine * chroma.x + cosine * chroma.y);
    // Green follows from red and blue, as luma is kept.
    float green_above = -dot(weights.br, above) / weights.g;
    vec3 turned = luma + vec3(above.y, green_above, above.x) + vec3(red, green, blue) / 255.0;
    return clipped_color(turned, picture);
}
