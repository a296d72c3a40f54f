#if __VERSION__ < 430
// One pixel for each fragment.
void main() {
    ivec2 place = ivec2(gl_FragCoord.xy);
    evaluate(origin + place * stride, place, true);
}
#else
// One pixel for each invocation.
void main() {
    ivec2 start = corner + ivec2(gl_WorkGroupID.xy * gl_WorkGroupSize.xy);
    ivec2 end = min(start + ivec2(gl_WorkGroupSize.xy), corner + size);
    prepare(origin + start, end - start);
    ivec2 place = corner + ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(place, end))) {
        evaluate(origin + place * stride, place, true);
    }
}
#endif
