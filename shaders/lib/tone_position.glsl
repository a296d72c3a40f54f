// Where a value lies among tones: each has a length of 1. The lift, larger than the rounding of a texture,
// gives the upper tone what lies just upon a border.
channels tone_position(channels value, int tones) {
    return (value + 5e-5) * float(tones);
}
