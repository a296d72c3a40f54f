// The cubic convolution kernel with the slope -0.75 at 1, OpenCV's. Keys 1981, equation 15.
float cubic_weight(float distance) {
    float x = distance;
    float near = (1.25 * x - 2.25) * x * x + 1.0;
    float far = ((-0.75 * x + 3.75) * x - 6.0) * x + 3.0;
    return x <= 1.0 ? near : x < 2.0 ? far : 0.0;
}

// The cubics of Mitchell and Netravali 1988 with B = 0 and C = 1/2 (Catmull and Rom) if a picture keeps its
// size or shrinks, and with B = 1 and C = 0, the B-spline, if it grows.
float smooth_weight(float distance, bool grows) {
    float x = distance;
    float near = grows ? (0.5 * x - 1.0) * x * x + 2.0 / 3.0 : (1.5 * x - 2.5) * x * x + 1.0;
    float rest = max(2.0 - x, 0.0);
    float far = grows ? rest * rest * rest / 6.0 : ((-0.5 * x + 2.5) * x - 4.0) * x + 2.0;
    return x < 1.0 ? near : x < 2.0 ? far : 0.0;
}

// The Lanczos kernel of four lobes: sinc(x) sinc(x / 4). Duchon 1979.
float lanczos_weight(float distance) {
    float turn = 3.14159265 * distance;
    float weight = 4.0 * sin(turn) * sin(0.25 * turn) / max(turn * turn, 1e-9);
    // The sine of such a small angle may be too inaccurate on a GPU for a division; a parabola is accurate there.
    float top = 1.0 - 1.74774 * distance * distance;
    return distance >= 4.0 ? 0.0 : distance < 0.02 ? top : weight;
}
