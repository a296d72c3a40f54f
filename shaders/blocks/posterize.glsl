#include "lib/soft_step.glsl"

// A few flat tones in each channel, with soft steps between them. Paper, section 3.2 A.
channels posterize(channels picture, int levels, float softness) {
    float last = float(levels) - 1.0;
    channels position = picture * float(levels);
    channels border = clamp(floor(position + 0.5), 1.0, last);
    channels risen = softness > 0.0 ? soft_step(position - border, softness) : step(border, position);
    return (border - 1.0 + risen) / last;
}
