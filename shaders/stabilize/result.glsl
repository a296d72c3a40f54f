#include "lib/warped_at.glsl"

// A plane of the result blended with the warped previous one: as stored for the next frame, and as codes.

layout(location = 0) out vec4 kept;
layout(location = 1) out vec4 codes;

uniform sampler2D before;
uniform sampler2D flow;
uniform sampler2D segment_weights;
uniform float gain;
uniform float most;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 value = texelFetch(plane, at, 0) * most * gain;
    if (blend_weight > 0.0) {
        vec4 old = warped_at(before, at, flow) * white;
        value += blend_weight * luma_weight_at(at) * in_segment(at, segment_weights).r * (old - value);
    }
    kept = value / white;
    codes = (most > 1.0 ? floor(value / gain + 0.503) : value) / most;
}
