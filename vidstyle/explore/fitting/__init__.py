"""Fitting of a style to the look of a picture."""
