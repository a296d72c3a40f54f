#include "lib/drawing_at.glsl"
#include "lib/stroke_direction.glsl"
#include "lib/white_noise.glsl"

// Strokes of one colour each along the edges, at random positions of a grid, from the topmost down.
vec3 strokes(
    ivec2 at, ivec2 page, uint moment, vec3 flow, vec3 under, float length_, float width, float density, float angle,
    float angle_strength, float variation, float colors, float bristles, int rate) {
    vec2 direction = stroke_direction(flow, fixed_stroke_direction(angle, angle_strength)), here = vec2(at) + 0.5;
    float pitch = max(width / sqrt(density), max(length_, width) / 5.0), reach = ceil(max(length_, width) / 2.0 + 1.0);
    float half_length = max(length_ - width, 0.0) / 2.0, half_width = width / 2.0, shown = 1.0, last_order = 2.0;
    int around = max_drift_squares();
    ivec2 first = ivec2(floor((here - reach) / pitch)) - 1 - around;
    ivec2 last = ivec2(ceil((here + reach) / pitch)) + around;
    vec3 color = vec3(0.0);
    int drawing = drawing_at(moment, rate) * APART;
    for (int layer = 0; layer < 16 && shown >= 1.0 / 512.0; layer++) {
        // The topmost stroke below the last one.
        float order = 0.0, cover = 0.0;
        ivec2 chosen = ivec2(0);
        vec2 middle = here, inside = vec2(0.0);
        for (int row = first.y; row <= last.y; row++) {
            for (int column = first.x; column <= last.x; column++) {
                vec2 moved = drift_of(ivec2(column, row), pitch, page), passed = floor(moved + 0.5);
                ivec2 point = ivec2(4 * (column - int(passed.x)), row - int(passed.y) + drawing);
                float own_order = white_noise(point + ivec2(2, 0));
                if (own_order <= order || own_order >= last_order)
                    continue;
                vec2 random = vec2(white_noise(point), white_noise(point + ivec2(1, 0)));
                vec2 own_middle = (vec2(column, row) + (random + (moved - passed))) * pitch, away = here - own_middle;
                vec2 place = abs(vec2(dot(away, direction), away.y * direction.x - away.x * direction.y));
                float own_cover = min(half_width + 0.5 - length(max(place - vec2(half_length, 0.0), 0.0)), 1.0);
                if (own_cover > 0.0) {
                    order = own_order;
                    cover = own_cover;
                    chosen = point;
                    middle = own_middle;
                    inside = place;
                }
            }
        }
        if (order == 0.0)
            break;
        last_order = order;
        float tone = white_noise(chosen + ivec2(3, 0));
        float mark = white_noise_between(tone * 512.0 + 64.0 + inside / vec2(16.0, 1.6), 0);
        float shade = variation * (tone - 0.5) + bristles * (mark - 0.5);
        vec3 plain = picture_at(ivec2(floor(middle)));
        float strength = max(max(plain.r, plain.g), plain.b) - min(min(plain.r, plain.g), plain.b);
        vec2 other = colors * min(0.15 + strength, 1.0) * (fract(tone * vec2(7.0, 13.0)) - 0.5);
        vec3 own = plain + shade + vec3(other.x, -0.5 * (other.x + other.y), other.y);
        color += shown * cover * clamp(own, 0.0, 1.0);
        shown -= shown * cover;
    }
    return color + shown * under;
}
