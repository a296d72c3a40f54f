#include "lib/line_point.glsl"

// Sum of a closing and an opening by lines in eight directions, minus the pixel: dark and bright marks that
// are short in each direction disappear. Soille and Talbot 2001.
float despeckle(ivec2 at, float length_, float contrast) {
    float own = picture_at(at), dark = 1e9, bright = -1e9;
    int reach = int(floor(length_ - 0.5));
    if (reach < 1)
        return own;
    for (int direction = 0; direction < 8; direction++) {
        vec2 most = vec2(own), least = vec2(own); // ahead and behind
        for (int number = 1; number <= 6; number++) {
            vec2 pair = vec2(
                picture_at(at + line_point(direction, number, reach)),
                picture_at(at + line_point(direction, -number, reach)));
            most = max(most, pair);
            least = min(least, pair);
            if (number == 3) {
                dark = min(dark, max(most.x, most.y));
                bright = max(bright, min(least.x, least.y));
            }
        }
        dark = min(dark, min(most.x, most.y));
        bright = max(bright, max(least.x, least.y));
    }
    float change = dark + bright - 2.0 * own, relative = change * 255.0 / contrast, squared = relative * relative;
    return own + change / (1.0 + squared * squared);
}
