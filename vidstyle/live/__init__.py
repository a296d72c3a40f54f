"""A live picture, restyled as it comes: cameras, screens and streams in, windows and streams out."""
