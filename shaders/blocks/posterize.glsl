#include "lib/soft_step.glsl"
#include "lib/tone_position.glsl"

// A few flat tones in each channel, with soft steps between them. Paper, section 4.2 A.
channels posterize(channels picture, int levels, float softness) {
    float last = float(levels) - 1.0;
    channels position = tone_position(picture, levels);
    channels border = clamp(floor(position + 0.5), 1.0, last);
    channels risen = softness > 0.0 ? soft_step(position - border, softness) : step(border, position);
    return (border - 1.0 + risen) / last;
}
