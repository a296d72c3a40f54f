#version 330

// The percentiles, interpolated between neighbouring samples, and smoothed over time.

uniform sampler2D ordered;
uniform sampler2D remembered;
uniform vec4 fractions;
uniform float weight;
uniform float low;
uniform float span;

out vec4 numbers;

vec4 neighbours(int which) {
    return vec4(
        texelFetch(ordered, ivec2(0, which), 0).r,
        texelFetch(ordered, ivec2(1, which), 0).r,
        texelFetch(ordered, ivec2(2, which), 0).r,
        texelFetch(ordered, ivec2(3, which), 0).r
    );
}

void main() {
    vec4 below = neighbours(0);
    // Highlights of HDR count as diffuse white, so that the other tones are stretched as in SDR.
    numbers = min(low + span * (below + fractions * (neighbours(1) - below)), 1.0);
    // With a weight of 1 the previous values may still be undefined, even NaN.
    if (weight < 1.0) {
        vec4 before = texelFetch(remembered, ivec2(0), 0);
        numbers = before + weight * (numbers - before);
    }
}
