// Invert the channels from a tone on. The lift, larger than the rounding of a texture, inverts values on the border.
channels invert(channels picture, float above) {
    channels chosen = step(above / 255.0, picture + 5e-5);
    return mix(picture, 1.0 - picture, chosen);
}
