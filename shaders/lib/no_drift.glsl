// Marks stay in their own squares.
const int MAX_DRIFT_SQUARES = 0;

vec2 drift_of(ivec2 square, float pitch, ivec2 page) {
    return vec2(0.0);
}
