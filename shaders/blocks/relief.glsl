// Luma as a height, lit from the side: half white plus the slope towards the light, 3 x 3 Sobel divided by 8.
float relief(ivec2 at, float depth, float angle) {
    float above_left = picture_at(at + ivec2(-1, -1)), below_right = picture_at(at + ivec2(1, 1));
    float above_right = picture_at(at + ivec2(1, -1)), below_left = picture_at(at + ivec2(-1, 1));
    float beside = picture_at(at + ivec2(1, 0)) - picture_at(at + ivec2(-1, 0));
    float under = picture_at(at + ivec2(0, 1)) - picture_at(at + ivec2(0, -1));
    float falling = below_right - above_left, rising = above_right - below_left;
    vec2 gradient = vec2(2.0 * beside + falling + rising, 2.0 * under + falling - rising);
    float turn = radians(angle);
    return clamp(0.5 + 0.125 * depth * (gradient.y * sin(turn) - gradient.x * cos(turn)), 0.0, 1.0);
}
