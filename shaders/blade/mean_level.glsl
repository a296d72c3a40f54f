// The bin of a local mean, in 1024ths like the numbers of filters.
float mean_level(float mean, float start, float density, float levels) {
    return floor(clamp((mean - start) * density, 0.0, levels - 0.5)) / 1024.0;
}

// The bin of a pixel minus its local mean.
float difference_level(float own, float mean, float start, float density, float levels) {
    return mean_level(own - mean, start, density, levels);
}

// The number of a filter after an additional feature has divided its bin.
float divided_choice(float chosen, float level, float levels) {
    return chosen * levels + level;
}
