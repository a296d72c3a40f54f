// Tones of a dim picture brightened by the share `lift` of the distance of its middle tone from 0.35, at most
// threefold; black and highlights above white stay unchanged.
float dim_lift(float luma, float middle, float lift) {
    float tone = clamp(luma, 0.0, 1.0);
    middle = clamp(middle, 0.0, 1.0);
    float risen = middle + lift * max(0.35 - middle, 0.0);
    float gain = risen > middle ? min(risen * (1.0 - middle) / max(middle * (1.0 - risen), 1e-3), 3.0) : 1.0;
    float growth = gain - 1.0;
    return luma + growth * tone * tone * (1.0 - tone) / ((tone + 0.03) * (1.0 + growth * tone));
}
