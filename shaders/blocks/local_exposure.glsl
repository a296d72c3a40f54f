// Shadows brightened relative to their wide surroundings, then all regions towards even light.
channels local_exposure(channels picture, float near, float wide, float lift, float even) {
    // No rim of light around dark figures: `near` is blurred.
    float level = dot(picture, channels(1.0)) / dot(channels(1.0), channels(1.0));
    float local = min(near + max(level - near - 0.12, 0.0), 1.0);
    float gain = 1.0 / (1.0 - min(lift * max(wide - local, 0.0), 0.8));
    channels lifted = min(picture * gain, max(picture, 1.0));
    float dark = 2.0 * (1.0 - local);
    return mix(lifted, lifted * (dark + lifted * (1.0 - dark)), even);
}
