#version 330

// One more sample in this bin; blending adds them up.

out float count;

void main() {
    count = 1.0;
}
