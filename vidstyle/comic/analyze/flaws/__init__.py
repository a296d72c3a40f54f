"""Defects of frames: damage, blur and combs."""
