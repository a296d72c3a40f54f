#include "lib/flow_at.glsl"
#include "lib/texel_between.glsl"

// A plane of the result with part of the one before in it: as it is kept, and as codes.

uniform sampler2D plane;
uniform sampler2D before;
uniform sampler2D flow;
uniform sampler2D guide;
uniform ivec2 size;
uniform vec2 across_down;
uniform float gain;
uniform float white;
uniform float most;
uniform float share;

layout(location = 0) out vec4 kept;
layout(location = 1) out vec4 codes;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 value = texelFetch(plane, at, 0) * most * gain;
    if (share > 0.0) {
        vec2 from = vec2(at) + flow_at(at, size, flow) / across_down;
        vec4 old = texel_between(before, from, size - 1) * white;
        float weight = texelFetch(guide, min(at * ivec2(across_down), textureSize(guide, 0) - 1), 0).r;
        value += share * weight * (old - value);
    }
    kept = value / white;
    codes = (most > 1.0 ? floor(value / gain + 0.503) : value) / most;
}
