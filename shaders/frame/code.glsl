// The integer sample that stands for a value, as what a normalized texture stores: halves are rounded up,
// and what leaves the range of numbers is cut off there. Means of a few codes of 8 bits lie at a half, and
// what a working texture takes off one, 0.0026 codes of chroma at most, must not round it down.
channels code(channels value, float black, float white, float top, float most) {
    return clamp(floor(value * (white - black) + black + 0.503), 0.0, top) / most;
}
