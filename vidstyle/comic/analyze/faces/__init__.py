"""Faces of candidate key frames: where they are, and whether eyes and mouths are open."""
