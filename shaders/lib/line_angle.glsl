// The doubled angle of the gradient of a structure tensor, in turns from 0 to 1; 0.5 without gradient.
float line_angle(vec3 tensor) {
    vec2 direction = 0.5 * vec2(2.0 * tensor.y, tensor.x - tensor.z);
    return 0.5 + atan(direction.y, direction.x + 1e-12) / 6.28318531;
}
