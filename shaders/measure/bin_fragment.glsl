#version 330

// Counts a sample in its bin, by additive blending.

out float count;

void main() {
    count = 1.0;
}
