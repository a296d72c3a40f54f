// The angle of a vector, -pi..pi, with an error of at most 0.22 degrees, identical on all devices; 0 for a zero vector.
// Rajan et al. 2006, equation 10.
float short_angle(vec2 direction) {
    vec2 sides = abs(direction);
    float slope = min(sides.x, sides.y) / (max(sides.x, sides.y) + 1e-12);
    float angle = slope * (0.785398163 + 0.273 * (1.0 - slope));
    angle = sides.y > sides.x ? 1.57079633 - angle : angle;
    angle = direction.x < 0.0 ? 3.14159265 - angle : angle;
    return direction.y < 0.0 ? -angle : angle;
}
