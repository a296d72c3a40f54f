// Shadows brightened relative to their wide surroundings, then all regions towards even light.
channels local_exposure(channels picture, float near, float wide, float lift, float even) {
    float gain = 1.0 / (1.0 - min(lift * max(wide - near, 0.0), 0.8));
    channels lifted = min(picture * gain, max(picture, 1.0));
    float dark = 2.0 * (1.0 - near);
    return mix(lifted, lifted * (dark + lifted * (1.0 - dark)), even);
}
