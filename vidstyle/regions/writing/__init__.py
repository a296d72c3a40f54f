"""Writing: thin strokes that a style would lose, drawn over its result."""
