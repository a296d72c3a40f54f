// Chroma that is the same everywhere.
vec2 plain_chroma(vec2 tint) {
    return tint;
}
