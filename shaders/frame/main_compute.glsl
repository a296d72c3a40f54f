// One pixel for each invocation.
void main() {
    ivec2 place = corner + ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(place, corner + size))) {
        evaluate(origin + place * stride, place, true);
    }
}
