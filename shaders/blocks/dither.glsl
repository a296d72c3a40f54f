// Adds a pattern of thresholds with a mean of 0 that repeats over the page. Bayer 1973, Ulichney 1993.
channels dither(
    channels picture, ivec2 at, float strength, float cell, sampler2DArray thresholds, ivec2 thresholds_size) {
    ivec2 point = at / int(cell + 0.5) % thresholds_size;
    return clamp(picture + strength * (texelFetch(thresholds, ivec3(point, 0), 0).r - 0.5), 0.0, 1.0);
}
