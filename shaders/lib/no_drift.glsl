// Marks lie in their own squares.
const int BESIDE = 0;

vec2 drift_of(ivec2 square, float pitch, ivec2 page) {
    return vec2(0.0);
}
