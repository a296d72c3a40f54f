"""Temporal stabilization of restyled films: each frame is blended with the warped previous one."""
