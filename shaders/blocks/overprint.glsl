// Three plates printed over each other in transparent inks on white paper.
vec3 overprint(vec3 picture, vec3 first, vec3 second, vec3 third) {
    vec3 amounts = 1.0 - picture;
    vec3 light = (1.0 - amounts.x * (1.0 - first)) * (1.0 - amounts.y * (1.0 - second));
    return light * (1.0 - amounts.z * (1.0 - third));
}
