"""Temporal stabilization of restyled films: blend each frame with the warped previous frame."""
