// The result of `chosen_with_angle`, from a number and an angle computed for 2 x 2 pixels.
vec2 number_and_angle(float number, float angle) {
    return vec2(number, angle);
}
