// The mean of the picture along a line of pixels, with the weights of a bell that ends at three sigma.
channels gaussian_along(ivec2 at, ivec2 next, float sigma) {
    // Each weight comes from the one before by a ratio that itself falls steadily: one exponential for all.
    // The floor keeps sigma 0, which takes no step, from dividing by zero.
    float ratio = exp(-0.5 / max(sigma * sigma, 1e-6));
    float fall = ratio * ratio, weight = 1.0, total = 1.0;
    channels sum = picture_at(at);
    ivec2 away = next;
    int radius = int(ceil(3.0 * sigma));
    for (int tap = 0; tap < radius; tap++, away += next) {
        weight *= ratio;
        ratio *= fall;
        total += 2.0 * weight;
        sum += weight * (picture_at(at + away) + picture_at(at - away));
    }
    return sum / total;
}
