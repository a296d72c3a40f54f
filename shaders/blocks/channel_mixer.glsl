#include "lib/clipped_color.glsl"

// Gray from shares of red, green and blue.
vec3 channel_mixer(vec3 picture, float red, float green, float blue) {
    return clipped_color(vec3(dot(picture, vec3(red, green, blue))), picture);
}
