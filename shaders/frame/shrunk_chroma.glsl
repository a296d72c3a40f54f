// Chroma averaged over the area of one sample of a subsampled plane: a box of one step, centred on the
// sample. Two equal weights if it is centred between pixels, 1-2-1 if on a pixel.
vec2 shrunk_chroma(ivec2 at, ivec2 step, vec2 siting) {
    vec2 centre = vec2(at * step) + siting;
    vec2 extent = 0.5 * vec2(step);
    // An axis without subsampling has one sample per pixel, independent of the siting.
    centre = mix(centre, vec2(at), equal(step, ivec2(1)));
    ivec2 start = ivec2(floor(centre - extent + 0.5));
    vec2 total = vec2(0.0);
    for (int row = 0; row <= step.y; row++) {
        float down = min(float(start.y + row) + 0.5, centre.y + extent.y)
            - max(float(start.y + row) - 0.5, centre.y - extent.y);
        for (int column = 0; column <= step.x; column++) {
            float across = min(float(start.x + column) + 0.5, centre.x + extent.x)
                - max(float(start.x + column) - 0.5, centre.x - extent.x);
            float share = max(down, 0.0) * max(across, 0.0);
            if (share > 0.0) {
                total += share * chroma_at(start + ivec2(column, row));
            }
        }
    }
    return total / float(step.x * step.y);
}
