// The Lanczos kernel of four lobes: sinc(x) sinc(x / 4). Duchon 1979.
float lanczos_weight(float distance) {
    float turn = 3.14159265 * distance;
    float weight = 4.0 * sin(turn) * sin(0.25 * turn) / max(turn * turn, 1e-9);
    return distance >= 4.0 ? 0.0 : distance < 1e-4 ? 1.0 : weight;
}
