// Which drawing is shown at a moment, in milliseconds, if there are so many a second.
int drawing_at(uint moment, int rate) {
    return int(moment * uint(rate) / 1000u);
}
