"""Keeps restyled films from boiling: what has not changed is carried on from frame to frame."""
