// What `chosen_with_angle` finds, of a number and an angle that were found for 2 x 2 pixels.
vec2 number_and_angle(float number, float angle) {
    return vec2(number, angle);
}
