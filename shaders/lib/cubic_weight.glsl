// The cubic convolution kernel with the slope -0.75 at 1, OpenCV's. Keys 1981, equation 15.
float cubic_weight(float distance) {
    float x = distance;
    float near = (1.25 * x - 2.25) * x * x + 1.0;
    float far = ((-0.75 * x + 3.75) * x - 6.0) * x + 3.0;
    return x <= 1.0 ? near : x < 2.0 ? far : 0.0;
}
