// Luma alone: the runner drops chroma. Paper, section 4.2 A.
float to_gray(float luma) {
    return luma;
}
