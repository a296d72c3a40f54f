"""Comic pages from films: key frames chosen, laid out, lettered and drawn."""
