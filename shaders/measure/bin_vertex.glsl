#version 330

// Places sample gl_VertexID on its bin; there is a bin for each 16-bit value.

uniform sampler2D samples;
uniform int width;

void main() {
    float sample_value = texelFetch(samples, ivec2(gl_VertexID % width, gl_VertexID / width), 0).r;
    int bin = int(sample_value * 65535.0 + 0.5);
    gl_Position = vec4((vec2(bin % 256, bin / 256) + 0.5) / 128.0 - 1.0, 0.0, 1.0);
    gl_PointSize = 1.0;
}
