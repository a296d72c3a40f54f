// White above a threshold, with a tanh ramp to black below it: 1 + tanh(min(0, phi (input - epsilon))).
// Paper, section 4.2 A, equation 1; Winnemoeller 2012.
channels soft_threshold(channels picture, float phi, float epsilon) {
    // Written with one exponential; its argument is limited to prevent overflow.
    channels below = clamp(phi * 255.0 * (picture - epsilon / 255.0), -20.0, 0.0);
    return 2.0 / (1.0 + exp(-2.0 * below));
}
