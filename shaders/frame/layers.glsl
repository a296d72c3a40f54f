// Constant luma.
float constant_luma(float level) {
    return level;
}

// Constant chroma.
vec2 constant_chroma(vec2 tint) {
    return tint;
}

// A picture multiplied by the colour of the paper.
vec3 on_paper(vec3 color, vec3 paper) {
    return clamp(color * paper, 0.0, 1.0);
}

// Ink where the lines are dark: lines * under + (1 - lines) * ink, for luma.
float inked_luma(float under, float lines, float ink) {
    return (under - ink) * lines + ink;
}

// Ink where the lines are dark: lines * under + (1 - lines) * ink, for chroma.
vec2 inked_chroma(vec2 under, float lines, vec2 ink) {
    return (under - ink) * lines + ink;
}

// Ink where the lines are dark: lines * under + (1 - lines) * ink, for RGB.
vec3 inked_color(vec3 under, float lines, vec3 ink) {
    return (under - ink) * lines + ink;
}
