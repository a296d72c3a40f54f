#include "lib/flow_at.glsl"
#include "lib/texel_between.glsl"

// What lay here in the plane before, and the square of how much it has changed since.

uniform sampler2D plane;
uniform sampler2D before;
uniform sampler2D flow;
uniform ivec2 size;
uniform vec2 across_down;
uniform vec2 scale;
uniform float white;

out vec2 moved;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec2 from = vec2(at) + flow_at(at, size, flow) / across_down;
    float old = texel_between(before, from, size - 1).r * white;
    float change = texelFetch(plane, at, 0).r * scale.x + scale.y - old;
    moved = vec2(old, change * change);
}
