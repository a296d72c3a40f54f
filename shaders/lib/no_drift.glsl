// Marks stay in their own squares.
int max_drift_squares() {
    return 0;
}

vec2 drift_of(ivec2 square, float pitch, ivec2 page) {
    return vec2(0.0);
}
