// The sines of angles in turns, reduced first to small angles, for which all GPUs agree.
vec3 sine_of_turns(vec3 turns) {
    return sin((turns - floor(turns + 0.5)) * 6.283185307);
}
