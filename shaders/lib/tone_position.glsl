// Position of a value among tones of length 1. The lift, larger than the rounding of a texture, assigns values
// on a border to the upper tone.
channels tone_position(channels value, int tones) {
    return (value + 5e-5) * float(tones);
}
