vec2 direction_at(ivec2 at) {
    float angle = 6.28318531 * (picture_at(at).y - 0.5);
    return vec2(cos(angle), sin(angle));
}

// The index of a filter after dividing its bin by the curvature of lines, the change of angle along them. The first
// `per_orientation` filters are for gradients to the right, whose angles may be slightly below 0; for other filters
// such an angle denotes the opposite direction.
float curved_choice(ivec2 at, float curvatures, float per_orientation, float curve) {
    float chosen = picture_at(at).x;
    vec2 own = direction_at(at);
    vec2 right = direction_at(at + ivec2(1, 0)) - direction_at(at - ivec2(1, 0));
    vec2 down = direction_at(at + ivec2(0, 1)) - direction_at(at - ivec2(0, 1));
    vec2 turns = 0.25 * vec2(own.x * right.y - own.y * right.x, own.x * down.y - own.y * down.x);
    vec2 half_angle = sqrt(max(0.5 + 0.5 * vec2(own.x, -own.x), 0.0));
    half_angle.y = own.y < 0.0 ? -half_angle.y : half_angle.y;
    float curvature = half_angle.x * turns.y - half_angle.y * turns.x;
    curvature = own.y < 0.0 && chosen * 1024.0 + 0.5 >= per_orientation ? -curvature : curvature;
    float share = 0.5 + 0.5 * curvature / (abs(curvature) + curve);
    return chosen * curvatures + floor(clamp(share * curvatures, 0.0, curvatures - 0.5)) / 1024.0;
}
