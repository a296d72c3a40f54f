#include "lib/warped_at.glsl"

// The previous plane, warped, and the squared change of each sample.

uniform sampler2D before;
uniform sampler2D flow;
uniform vec2 scale;

out vec2 warped;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    float old = warped_at(before, at, flow).r * white;
    float change = texelFetch(plane, at, 0).r * scale.x + scale.y - old;
    warped = vec2(old, change * change);
}
