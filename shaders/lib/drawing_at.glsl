// The number of the drawing shown at a moment, in milliseconds, at `rate` drawings per second.
int drawing_at(uint moment, int rate) {
    return int(moment * uint(rate) / 1000u);
}
