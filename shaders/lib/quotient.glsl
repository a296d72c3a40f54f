// A share 0..1 of two values; what is darker than one level of 255 divides like that.
channels quotient(channels part, channels whole) {
    return clamp(part / max(whole, 1.0 / 255.0), 0.0, 1.0);
}
