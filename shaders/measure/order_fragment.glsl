#version 330

// The sample of rank ranks[x] + y among all sorted samples, 0..1.

uniform sampler2D bins;
uniform sampler2D rows;
uniform vec4 ranks;

out float value;

// Number of bins to the right of `start`, at most 255, after which more than `rank` samples are passed; `rank`
// is reduced by the samples before that bin.
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
