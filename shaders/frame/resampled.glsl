#include "lib/resampling.glsl"

// A picture resampled to another size, as by OpenCV: pixel areas are mapped, so corners stay corners. Positions are a
// whole pixel and an exact fraction, as one float would lose the fraction in wide pictures. `border` pixels on every
// side of the new picture lie beyond the page, or -`border` of the old one.
channels resampled(ivec2 at, int method, ivec2 old_size, ivec2 new_size, int border) {
    int added = max(border, 0), removed = max(-border, 0);
    at -= added;
    old_size -= 2 * removed;
    new_size -= 2 * added;
    if (method == resampled_method_nearest) {
        return picture_at((2 * at + 1) * old_size / (2 * new_size));
    }
    ivec2 first = at * old_size / new_size;
    vec2 part = vec2(at * old_size - first * new_size) / vec2(new_size);
    vec2 scale = vec2(old_size) / vec2(new_size);
    ivec2 taps = ivec2(2);
    vec2 stretch = max(scale, 1.0);
    bool averages = method == resampled_method_area;
    if (averages) {
        taps = ivec2(ceil(part + scale));
    } else {
        ivec2 whole = added * (old_size / new_size + 1); // division rounds negative numbers up
        ivec2 moved = (2 * at + 1) * old_size + new_size + 2 * new_size * whole;
        first = moved / (2 * new_size);
        part = vec2(moved - first * 2 * new_size) / vec2(2 * new_size);
        first += removed - whole;
        taps = ivec2(method == resampled_method_bilinear ? 2 : method == resampled_method_bicubic ? 4 : 8);
        if (method == resampled_method_smooth) {
            taps = 2 * ivec2(ceil(2.0 * stretch));
        }
        first -= taps / 2;
    }
    channels total = channels(0.0);
    float weights = 0.0;
    for (int row = 0; row < taps.y; row++) {
        for (int column = 0; column < taps.x; column++) {
            vec2 tap = vec2(column, row);
            vec2 distance = abs(tap - part - vec2(taps / 2 - 1));
            vec2 share = max(1.0 - distance, 0.0);
            if (averages) {
                share = max(min(part + scale, tap + 1.0) - max(part, tap), 0.0);
            } else if (method == resampled_method_bicubic) {
                share = vec2(cubic_weight(distance.x), cubic_weight(distance.y));
            } else if (method == resampled_method_smooth) {
                share.x = smooth_weight(distance.x / stretch.x, old_size.x < new_size.x);
                share.y = smooth_weight(distance.y / stretch.y, old_size.y < new_size.y);
            } else if (method == resampled_method_lanczos) {
                share = vec2(lanczos_weight(distance.x), lanczos_weight(distance.y));
            }
            total += share.x * share.y * picture_at(first + ivec2(column, row));
            weights += share.x * share.y;
        }
    }
    return total / weights;
}
