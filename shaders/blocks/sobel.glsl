// Magnitude of the luma gradient: 3 x 3 Sobel divided by 4, clipped at white. Paper, section 4.2 B.
float sobel(ivec2 at, float gain, bool invert) {
    float above_left = picture_at(at + ivec2(-1, -1)), below_right = picture_at(at + ivec2(1, 1));
    float above_right = picture_at(at + ivec2(1, -1)), below_left = picture_at(at + ivec2(-1, 1));
    float beside = picture_at(at + ivec2(1, 0)) - picture_at(at + ivec2(-1, 0));
    float under = picture_at(at + ivec2(0, 1)) - picture_at(at + ivec2(0, -1));
    float falling = below_right - above_left, rising = above_right - below_left;
    vec2 gradient = vec2(2.0 * beside + falling + rising, 2.0 * under + falling - rising);
    float edge = min(0.25 * gain * length(gradient), 1.0);
    return invert ? 1.0 - edge : edge;
}
