"""Styles that change over time: cue lists, and the renderer that follows them."""
