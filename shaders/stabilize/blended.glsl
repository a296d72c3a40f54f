#include "lib/warped_at.glsl"

// The plane blended with the warped previous one, and the weights of the latter.

uniform sampler2D warped;
uniform vec2 scale;
uniform float rate;
uniform bool guided;

layout(location = 0) out float kept;
layout(location = 1) out float weight;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float value = texelFetch(plane, at, 0).r * scale.x + scale.y;
    weight = 0.0;
    if (blend_weight > 0.0) {
        float change = 0.0;
        for (int row = -1; row <= 1; row++) {
            for (int column = -1; column <= 1; column++) {
                change += texelFetch(warped, clamp(at + ivec2(column, row), ivec2(0), size - 1), 0).g;
            }
        }
        weight = 1.0 / (1.0 + (change * rate) * (change * rate));
        if (guided) {
            weight *= luma_weight_at(at);
        }
        value += blend_weight * weight * (texelFetch(warped, at, 0).r - value);
    }
    kept = value / white;
}
