"""Comic pages from films: select, lay out, letter and draw key frames."""
