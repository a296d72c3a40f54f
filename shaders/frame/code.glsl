// The integer sample of a value, as stored in a normalized texture. Halves are rounded up, including values that
// are slightly below a half because of rounding, as in `vidstyle.core.planes.store`; values are clamped to the range of
// the samples.
channels code(channels value, float black, float white, float top, float most) {
    return clamp(floor(value * (white - black) + black + 0.503), 0.0, top) / most;
}
