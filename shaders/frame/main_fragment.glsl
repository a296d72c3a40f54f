// One pixel for each fragment.
void main() {
    ivec2 place = ivec2(gl_FragCoord.xy);
    evaluate(origin + place * stride, place, true);
}
