// The index of a pixel's filter among the filters selected for 2 x 2 pixels.
float IMAGE_own_choice(ivec2 at) {
    vec4 numbers = IMAGE_at(at / 2);
    vec2 column = at.x % 2 == 0 ? numbers.xz : numbers.yw;
    return at.y % 2 == 0 ? column.x : column.y;
}
