// The quotient of two values, clipped to 0..1; the divisor is at least one level of 255.
channels quotient(channels part, channels whole) {
    return clamp(part / max(whole, 1.0 / 255.0), 0.0, 1.0);
}
