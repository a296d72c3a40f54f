// Hard light: multiply where the upper picture is dark, screen where it is bright.
channels hard_light(channels below, channels above) {
    channels screened = 1.0 - 2.0 * (1.0 - below) * (1.0 - above);
    return mix(2.0 * below * above, screened, step(0.5, above));
}
