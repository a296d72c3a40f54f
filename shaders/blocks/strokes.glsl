#include "lib/stroke_direction.glsl"
#include "lib/white_noise.glsl"

// A stroke over what lies below it: the colour of the picture in its middle, changed by its own tone and by `shade`.
vec3 stroke_over(vec3 below, vec2 middle, float cover, float tone, float colors, float shade) {
    vec2 other = colors * (fract(tone * vec2(7.0, 13.0)) - 0.5);
    vec3 own = picture_at(ivec2(floor(middle))) + shade + vec3(other.x, -0.5 * (other.x + other.y), other.y);
    return mix(below, clamp(own, 0.0, 1.0), cover);
}

// Strokes of one colour each at random places of a grid, along the edges; two of them are seen at a pixel at most.
vec3 strokes(
    ivec2 at, vec3 flow, vec3 under, float length_, float width, float density, float angle, float variation,
    float colors, float bristles) {
    vec2 direction = stroke_direction(flow, fixed_stroke_direction(angle)), here = vec2(at) + 0.5;
    float pitch = max(width / sqrt(density), max(length_, width) / 5.0), reach = ceil(max(length_, width) / 2.0 + 1.0);
    float half_length = max(length_ - width, 0.0) / 2.0, half_width = width / 2.0;
    ivec2 first = ivec2(floor((here - reach) / pitch)) - 1, last = ivec2(ceil((here + reach) / pitch));
    // Of the uppermost and of the next: order, coverage and tone; where its middle is.
    vec3 upper = vec3(0.0), lower = vec3(0.0);
    vec2 upper_middle = here, lower_middle = here, inside = vec2(0.0);
    for (int row = first.y; row <= last.y; row++) {
        for (int column = first.x; column <= last.x; column++) {
            ivec2 point = ivec2(4 * column, row);
            vec2 random = vec2(white_noise(point), white_noise(point + ivec2(1, 0)));
            vec2 middle = (vec2(column, row) + random) * pitch, away = here - middle;
            float along = dot(away, direction), across = away.y * direction.x - away.x * direction.y;
            vec2 beyond = vec2(max(abs(along) - half_length, 0.0), across);
            float cover = min(half_width + 0.5 - length(beyond), 1.0);
            if (cover <= 0.0)
                continue;
            vec3 stroke = vec3(white_noise(point + ivec2(2, 0)), cover, white_noise(point + ivec2(3, 0)));
            if (stroke.x > upper.x) {
                lower = upper;
                lower_middle = upper_middle;
                upper = stroke;
                upper_middle = middle;
                inside = vec2(along, across);
            } else if (stroke.x > lower.x) {
                lower = stroke;
                lower_middle = middle;
            }
        }
    }
    vec3 color = under;
    if (lower.y > 0.0)
        color = stroke_over(color, lower_middle, lower.y, lower.z, colors, variation * (lower.z - 0.5));
    if (upper.y > 0.0) {
        float mark = white_noise_between(upper.z * 512.0 + 64.0 + inside / vec2(16.0, 1.6));
        float shade = variation * (upper.z - 0.5) + bristles * (mark - 0.5);
        color = stroke_over(color, upper_middle, upper.y, upper.z, colors, shade);
    }
    return color;
}
