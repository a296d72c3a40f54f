// 0 below a border and 1 above it, with a cubic ramp of width `softness` across it.
channels soft_step(channels above_border, float softness) {
    channels ramp = clamp(above_border / max(softness, 1e-6) + 0.5, 0.0, 1.0);
    return ramp * ramp * (3.0 - 2.0 * ramp);
}
