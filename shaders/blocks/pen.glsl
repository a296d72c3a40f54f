// Crests of bright ridges as black lines on white, across the direction of the strongest negative curvature.
// Steger 1998.
float pen(ivec2 at, float width, float threshold) {
    float here = picture_at(at), left = picture_at(at + ivec2(-1, 0)), right = picture_at(at + ivec2(1, 0));
    float above = picture_at(at + ivec2(0, -1)), below = picture_at(at + ivec2(0, 1));
    float falling = picture_at(at + ivec2(1, 1)) + picture_at(at + ivec2(-1, -1));
    float rising = picture_at(at + ivec2(1, -1)) + picture_at(at + ivec2(-1, 1));
    float across = 0.5 * (right - left), down = 0.5 * (below - above);
    float bent_across = right - 2.0 * here + left, bent_down = below - 2.0 * here + above;
    float twist = 0.25 * (falling - rising), stretch = 0.5 * (bent_across - bent_down);
    float size = max(length(vec2(stretch, twist)), 1e-6);
    float curvature = max(size - 0.5 * (bent_across + bent_down), 1e-6);
    float steep = across * across * (size - stretch) + down * down * (size + stretch) - 2.0 * across * down * twist;
    steep = 0.5 * max(steep, 0.0) / size;
    float height = here + 0.5 * steep / curvature;
    float strength = clamp((height - threshold / 510.0) * 255.0 / max(threshold, 1.0), 0.0, 1.0);
    float sharpness = min(16.0 * width * width * curvature / max(height, 1e-6), 1.0);
    float drawn = sharpness * width * strength * strength * (3.0 - 2.0 * strength);
    float distance = sqrt(steep) / (curvature + steep / max(here, 1e-6));
    return 1.0 - clamp(0.5 * drawn + 0.5 - distance, 0.0, min(drawn, 1.0));
}
