// Ink where the lines are dark: lines * under + (1 - lines) * ink, for chroma.
vec2 inked_chroma(vec2 under, float lines, vec2 ink) {
    return (under - ink) * lines + ink;
}
