// A number for a texture of one float; or as the sum of two half floats, with twice the digits.
vec4 halves(float number, bool halved) {
    float first = halved ? unpackHalf2x16(packHalf2x16(vec2(number, 0.0))).x : number;
    return vec4(first, number - first, 0.0, 0.0);
}
