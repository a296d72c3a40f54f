#include "lib/unit_direction.glsl"

// The fixed direction for areas without edges, as a doubled angle.
vec2 fixed_stroke_direction(float angle, float strength) {
    vec2 own = unit_direction(angle);
    return strength * vec2(own.x * own.x - own.y * own.y, -2.0 * own.x * own.y);
}

// The unit vector along the edge, from a smoothed structure tensor; without edge, along the fixed direction.
vec2 stroke_direction(vec3 flow, vec2 fixed_direction) {
    vec2 twice = fixed_direction - (2.0 * flow.xy - 1.0);
    twice /= max(length(twice), 1e-12);
    // Half the angle: the longer component by its root; the other, which would lose digits, by their product.
    float longer = sqrt(0.5 + 0.5 * abs(twice.x)), shorter = abs(twice.y) / (2.0 * longer);
    vec2 way = twice.x < 0.0 ? vec2(shorter, longer) : vec2(longer, shorter);
    return twice.y < 0.0 ? vec2(way.x, -way.y) : way;
}
