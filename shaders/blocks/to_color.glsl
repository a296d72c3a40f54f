// Luma as it is: the runner puts the saved chroma to it. Paper, section 4.2 A.
float to_color(float luma) {
    return luma;
}
