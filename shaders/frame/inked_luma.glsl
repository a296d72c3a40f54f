// Ink where the lines are dark: lines * under + (1 - lines) * ink, for luma.
float inked_luma(float under, float lines, float ink) {
    return (under - ink) * lines + ink;
}
