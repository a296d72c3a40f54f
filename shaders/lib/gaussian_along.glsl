// The Gaussian mean of the picture along a line of pixels, truncated at three sigma.
channels gaussian_along(ivec2 at, ivec2 next, float sigma) {
    // Each weight follows from the previous one by a ratio that decreases by a constant factor: one exponential.
    // The lower limit keeps sigma 0, which has no neighbours, from dividing by zero.
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
