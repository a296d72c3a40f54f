// The best amount of an ink over given amounts of the two others.
float amount_of_ink(vec3 picture, vec3 ink, vec3 one, float one_amount, vec3 other, float other_amount) {
    vec3 light = (1.0 - one_amount * one) * (1.0 - other_amount * other), slope = light * ink;
    return clamp(dot(slope, light - picture) / (1e-6 + dot(slope, slope)), 0.0, 1.0);
}

// The amounts of three inks that print the picture, by coordinate descent, as plates: black where full.
vec3 separate(vec3 picture, vec3 first, vec3 second, vec3 third) {
    vec3 one = 1.0 - first, two = 1.0 - second, three = 1.0 - third, amounts = vec3(0.0);
    for (int sweep = 0; sweep < 4; sweep++) {
        amounts.z = amount_of_ink(picture, three, one, amounts.x, two, amounts.y);
        amounts.y = amount_of_ink(picture, two, one, amounts.x, three, amounts.z);
        amounts.x = amount_of_ink(picture, one, two, amounts.y, three, amounts.z);
    }
    return 1.0 - amounts;
}
