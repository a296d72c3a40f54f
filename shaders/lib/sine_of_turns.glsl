// The sines of angles in turns, brought near 0 first, where every GPU agrees.
vec3 sine_of_turns(vec3 turns) {
    return sin((turns - floor(turns + 0.5)) * 6.283185307);
}
