// Luma that is the same everywhere.
float plain_luma(float level) {
    return level;
}
