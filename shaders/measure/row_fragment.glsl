#version 330

// Number of samples in row x of the bins.

uniform sampler2D bins;

out float count;

void main() {
    int row = int(gl_FragCoord.x);
    count = 0.0;
    for (int column = 0; column < 256; ++column) {
        count += texelFetch(bins, ivec2(column, row), 0).r;
    }
}
