// 3 x 3 Sobel differences to the right and down; a step from black to white gives 4.
void sobel_gradient(ivec2 at, out channels across, out channels down) {
    channels above_left = picture_at(at + ivec2(-1, -1)), below_right = picture_at(at + ivec2(1, 1));
    channels above_right = picture_at(at + ivec2(1, -1)), below_left = picture_at(at + ivec2(-1, 1));
    channels beside = picture_at(at + ivec2(1, 0)) - picture_at(at + ivec2(-1, 0));
    channels under = picture_at(at + ivec2(0, 1)) - picture_at(at + ivec2(0, -1));
    channels falling = below_right - above_left, rising = above_right - below_left;
    across = 2.0 * beside + falling + rising;
    down = 2.0 * under + falling - rising;
}
