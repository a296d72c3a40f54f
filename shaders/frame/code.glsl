// The integer sample that stands for a value, as what a normalized texture stores: halves are rounded up, also
// those that rounding has left a little below, as `vidstyle.core.planes.store` does; and what leaves the range of
// numbers is cut off there.
channels code(channels value, float black, float white, float top, float most) {
    return clamp(floor(value * (white - black) + black + 0.503), 0.0, top) / most;
}
