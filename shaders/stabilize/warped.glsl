#include "lib/warped_at.glsl"

// The plane before, warped, and the square of how much each sample has changed since.

uniform sampler2D plane;
uniform sampler2D before;
uniform sampler2D flow;
uniform ivec2 size;
uniform vec2 luma_step;
uniform vec2 scale;
uniform float white;

out vec2 warped;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float old = warped_at(before, at, size, flow, luma_step).r * white;
    float change = texelFetch(plane, at, 0).r * scale.x + scale.y - old;
    warped = vec2(old, change * change);
}
