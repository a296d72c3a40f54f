#include "lib/drawing_at.glsl"
#include "lib/stroke_direction.glsl"
#include "lib/white_noise.glsl"

// Noise smeared along the edges, in steps as long as the size of the noise. Cabral and Leedom 1993.
vec3 lic(ivec2 at, uint moment, float length_, float size, float angle, float angle_strength, float contrast,
    int rate) {
    vec2 fixed_direction = fixed_stroke_direction(angle, angle_strength);
    int steps = int(ceil(length_ / 2.0 / size)), drawing = drawing_at(moment, rate) * APART;
    float total = float(steps + 1), per_pixel = 1.0 / size, reach = ceil(float(steps) * size) + 2.0;
    vec2 start = vec2(at) + 0.5;
    float mean = white_noise_between(start * per_pixel, drawing);
    for (int side = 0; side < 2; side++) {
        vec2 direction = stroke_direction(picture_at(at), fixed_direction), away = vec2(0.0);
        direction = side == 0 ? direction : -direction;
        float weight = 1.0;
        for (int number = 0; number < steps; number++) {
            away += size * direction; // relative to the pixel, as absolute positions lose precision
            weight -= 1.0 / total;
            mean += weight * white_noise_between((start + away) * per_pixel, drawing);
            vec2 next = stroke_direction(picture_at(at - int(reach) + ivec2(reach + 0.5 + away)), fixed_direction);
            direction = dot(next, direction) < 0.0 ? -next : next;
        }
    }
    float gain = contrast * sqrt(1.0 + length_ / (2.0 * size));
    return vec3(clamp(0.5 + gain * (mean / total - 0.5), 0.0, 1.0));
}
