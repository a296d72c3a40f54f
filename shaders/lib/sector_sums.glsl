// The weights of four sectors a right angle apart, not yet normalized.
vec4 sector_weights(vec2 place, float lift, float narrowness) {
    vec2 squared = place * place;
    vec4 weights = max(vec4(place, -place) + lift - narrowness * squared.yxyx, 0.0);
    return weights * weights;
}

// Weighted sums over four sectors.
struct FourSums {
    vec4 red, green, blue, squares, weights;
};

void add_pixel(inout FourSums sums, vec4 weights, vec3 value) {
    sums.red += weights * value.r;
    sums.green += weights * value.g;
    sums.blue += weights * value.b;
    sums.squares += weights * dot(value, value);
    sums.weights += weights;
}

// The sum of the sectors' means, each weighted by the uniformity of the sector, and the sum of these weights.
vec4 sum_of_means(FourSums sums, int sharpness) {
    vec4 red = sums.red / sums.weights, green = sums.green / sums.weights, blue = sums.blue / sums.weights;
    vec4 variance = 255.0 * abs(sums.squares / sums.weights - red * red - green * green - blue * blue);
    for (int each = 0; each < sharpness; each++)
        variance *= variance;
    vec4 even = 1.0 / (1.0 + variance);
    return vec4(dot(even, red), dot(even, green), dot(even, blue), dot(even, vec4(1.0)));
}
