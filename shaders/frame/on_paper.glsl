// A transparent picture on coloured paper.
vec3 on_paper(vec3 color, vec3 paper) {
    return clamp(color * paper, 0.0, 1.0);
}
