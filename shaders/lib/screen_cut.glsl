// The height above which a halftone screen has just this share of its area: the polynomial of the block's
// Python. `per_pixel` is how much of a cell a pixel is.
float screen_cut(float share, float per_pixel) {
    float x = 1.0 - 2.0 * share;
    float x2 = x * x, x4 = x2 * x2;
    float odd = 0.25987756 + 0.46864727 * x2 - 0.43836827 * x4 + 0.20984343 * x4 * x2;
    float lift = per_pixel * (1.5 * per_pixel + 0.25);
    return 0.5 + x * (odd + lift * x2 * x4 * x4 * x4);
}
