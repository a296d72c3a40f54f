// The plane with part of the one before in it, and the weight of that.

uniform sampler2D plane;
uniform sampler2D moved;
uniform sampler2D guide;
uniform ivec2 size;
uniform vec2 across_down;
uniform vec2 scale;
uniform float white;
uniform float share;
uniform float rate;
uniform bool guided;

layout(location = 0) out float kept;
layout(location = 1) out float weight;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float value = texelFetch(plane, at, 0).r * scale.x + scale.y;
    weight = 0.0;
    if (share > 0.0) {
        float change = 0.0;
        for (int row = -1; row <= 1; row++) {
            for (int column = -1; column <= 1; column++) {
                change += texelFetch(moved, clamp(at + ivec2(column, row), ivec2(0), size - 1), 0).g;
            }
        }
        weight = 1.0 / (1.0 + (change * rate) * (change * rate));
        if (guided) {
            ivec2 last = textureSize(guide, 0) - 1;
            weight *= texelFetch(guide, min(at * ivec2(across_down), last), 0).r;
        }
        value += share * weight * (texelFetch(moved, at, 0).r - value);
    }
    kept = value / white;
}
