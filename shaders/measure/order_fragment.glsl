#version 330

// The sample of rank ranks[x] + y among all samples in order, as 0..1.

uniform sampler2D bins;
uniform sampler2D rows;
uniform vec4 ranks;

out float value;

// How far to go from `start` in steps of `along` until more than `rank` samples lie behind, 255 at most;
// `rank` becomes the one that remains.
int place(sampler2D counts, ivec2 start, inout float rank) {
    int step_number = 0;
    float count = texelFetch(counts, start, 0).r;
    while (step_number < 255 && count <= rank) {
        rank -= count;
        ++step_number;
        count = texelFetch(counts, start + ivec2(step_number, 0), 0).r;
    }
    return step_number;
}

void main() {
    float rank = ranks[int(gl_FragCoord.x)] + floor(gl_FragCoord.y);
    int row = place(rows, ivec2(0), rank);
    int column = place(bins, ivec2(0, row), rank);
    value = float(row * 256 + column) / 65535.0;
}
