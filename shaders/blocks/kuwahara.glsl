#include "lib/sector_sums.glsl"

const float kuwahara_orientations = 32.0, kuwahara_anisotropies = 8.0;

// The mean of eight sectors of an ellipse along the flow, each weighted by its uniformity.
// Kyprianidis et al. 2009, 2010.
vec3 kuwahara(ivec2 at, vec3 flow, float radius, float stretch, int sharpness) {
    vec2 twice = 2.0 * flow.xy - 1.0;
    float clearness = length(twice) / max(flow.z, 1e-6) * kuwahara_anisotropies;
    float turns = twice == vec2(0.0) ? 0.0 : atan(twice.y, twice.x) * kuwahara_orientations / 6.283185307;
    float angle = 3.141592654 * (floor(turns + 0.5) / kuwahara_orientations + 0.5);
    float shape = floor(clamp(clearness, 0.0, kuwahara_anisotropies - 1.0));
    float longer = 1.0 + stretch * (shape + 0.5) / kuwahara_anisotropies;
    int spacing = 2 * max(int((radius / 4.0 - 1.0) / 2.0 + 0.001), 0) + 1, half_square = spacing / 2;
    float samples = radius / float(spacing); // from the middle to the border
    // Errors of a GPU in both, up to a thousandth, would decide about pixels on the border.
    vec2 axis = normalize(vec2(cos(angle), sin(angle))), sides = vec2(samples * longer, samples / longer);
    float lift = 2.0 / samples, crossing = sin(0.58), narrowness = (lift + cos(0.58)) / (crossing * crossing);
    vec4 none = vec4(0.0);
    FourSums straight = FourSums(none, none, none, none, none), diagonal = straight;
    ivec2 reach = ivec2(ceil(vec2(length(axis * sides), length(axis.yx * sides)) + 0.01));
    for (int row = -reach.y; row <= reach.y; row++) {
        for (int column = -reach.x; column <= reach.x; column++) {
            vec2 away = vec2(column, row);
            vec2 place = vec2(dot(axis, away), axis.x * away.y - axis.y * away.x) / sides;
            float squared = dot(place, place);
            if (squared > 1.0001) // rounding must not decide about pixels just on the border
                continue;
            vec4 ahead = sector_weights(place, lift, narrowness);
            vec4 between = sector_weights(0.7071067812 * vec2(place.x - place.y, place.x + place.y), lift, narrowness);
            float share = exp(-3.125 * squared) / (dot(ahead, vec4(1.0)) + dot(between, vec4(1.0)));
            share /= float(spacing * spacing);
            for (int down = -half_square; down <= half_square; down++) {
                for (int right = -half_square; right <= half_square; right++) {
                    ivec2 there = at + spacing * ivec2(column, row) + ivec2(right, down);
                    vec3 value = clamp(picture_at(there), -1.0, 2.0);
                    add_pixel(straight, share * ahead, value);
                    add_pixel(diagonal, share * between, value);
                }
            }
        }
    }
    vec4 sum = sum_of_means(straight, sharpness) + sum_of_means(diagonal, sharpness);
    return sum.rgb / sum.a;
}
