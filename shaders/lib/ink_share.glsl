// The share of its cell that an ink covers to print a colour: 0 cyan, 1 magenta, 2 yellow, 3 black, which
// takes over what the other three have in common.
float ink_share(vec3 color, int ink, float black) {
    float key = black * (1.0 - max(color.r, max(color.g, color.b)));
    vec3 others = (1.0 - color - key) / max(1.0 - key, 1e-3);
    return clamp(vec4(others, key)[ink], 0.0, 1.0);
}
