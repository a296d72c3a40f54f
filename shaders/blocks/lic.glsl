#include "lib/unit_direction.glsl"
#include "lib/white_noise.glsl"

// The unit vector along the edge; where there is none, along a fixed direction.
vec2 stroke_direction(ivec2 at, vec2 fixed_direction) {
    vec2 twice = fixed_direction - (2.0 * picture_at(at).xy - 1.0);
    twice /= max(length(twice), 1e-12);
    // Half the angle: the longer part by its root, the other, which would lose digits so, by their product.
    float longer = sqrt(0.5 + 0.5 * abs(twice.x)), shorter = abs(twice.y) / (2.0 * longer);
    vec2 way = twice.x < 0.0 ? vec2(shorter, longer) : vec2(longer, shorter);
    return twice.y < 0.0 ? vec2(way.x, -way.y) : way;
}

// Noise smeared along the edges, by steps as long as the noise is coarse. Cabral and Leedom 1993.
vec3 lic(ivec2 at, float length_, float size, float angle, float contrast) {
    vec2 own = unit_direction(angle);
    vec2 fixed_direction = 0.06 * vec2(own.x * own.x - own.y * own.y, -2.0 * own.x * own.y);
    int steps = int(ceil(length_ / 2.0 / size));
    float total = float(steps + 1), per_pixel = 1.0 / size;
    vec2 start = vec2(at) + 0.5;
    float mean = white_noise_between(start * per_pixel);
    for (int side = 0; side < 2; side++) {
        vec2 direction = stroke_direction(at, fixed_direction), place = start;
        direction = side == 0 ? direction : -direction;
        float weight = 1.0;
        for (int number = 0; number < steps; number++) {
            place += size * direction;
            weight -= 1.0 / total;
            mean += weight * white_noise_between(place * per_pixel);
            vec2 next = stroke_direction(ivec2(floor(place)), fixed_direction);
            direction = dot(next, direction) < 0.0 ? -next : next;
        }
    }
    float gain = contrast * sqrt(1.0 + length_ / (2.0 * size));
    return vec3(clamp(0.5 + gain * (mean / total - 0.5), 0.0, 1.0));
}
