#version 330

// The sample of rank ranks[x] + y among all sorted samples, 0..1.

uniform sampler2D bins;
uniform sampler2D rows;
uniform vec4 ranks;

out float value;

// Counts that are read together: the search waits for a texture before it can decide which count is next.
const int TOGETHER = 16;

// Number of bins to the right of `start`, at most 255, after which more than `rank` samples are passed; `rank`
// is reduced by the samples before that bin.
int place(sampler2D counts, ivec2 start, inout float rank) {
    int passed = 0;
    bool is_found = false;
    for (int first = 0; first < 256 && !is_found; first += TOGETHER) {
        float count[TOGETHER];
        for (int each = 0; each < TOGETHER; ++each) {
            count[each] = texelFetch(counts, start + ivec2(first + each, 0), 0).r;
        }
        for (int each = 0; each < TOGETHER; ++each) {
            is_found = is_found || passed == 255 || count[each] > rank;
            passed += is_found ? 0 : 1;
            rank -= is_found ? 0.0 : count[each];
        }
    }
    return passed;
}

void main() {
    float rank = ranks[int(gl_FragCoord.x)] + floor(gl_FragCoord.y);
    int row = place(rows, ivec2(0), rank);
    int column = place(bins, ivec2(0, row), rank);
    value = float(row * 256 + column) / 65535.0;
}
