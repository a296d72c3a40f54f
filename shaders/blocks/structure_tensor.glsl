float luma_beside(ivec2 at, vec3 weights) {
    return dot(picture_at(at), weights);
}

// Direction and strength of edges as colours: doubled angles, weighted by the root of the gradient's magnitude.
vec3 structure_tensor(ivec2 at, vec3 weights) {
    float above_left = luma_beside(at + ivec2(-1, -1), weights);
    float below_right = luma_beside(at + ivec2(1, 1), weights);
    float above_right = luma_beside(at + ivec2(1, -1), weights);
    float below_left = luma_beside(at + ivec2(-1, 1), weights);
    float beside = luma_beside(at + ivec2(1, 0), weights) - luma_beside(at + ivec2(-1, 0), weights);
    float under = luma_beside(at + ivec2(0, 1), weights) - luma_beside(at + ivec2(0, -1), weights);
    float falling = below_right - above_left, rising = above_right - below_left;
    vec2 gradient = 0.25 * vec2(2.0 * beside + falling + rising, 2.0 * under + falling - rising);
    float squared = dot(gradient, gradient);
    float strength = sqrt(min(sqrt(squared), 1.0));
    float each = 0.5 * strength / max(squared, 1e-20);
    float twice_x = gradient.x * gradient.x - gradient.y * gradient.y, twice_y = 2.0 * gradient.x * gradient.y;
    return vec3(0.5 + each * twice_x, 0.5 + each * twice_y, strength);
}
