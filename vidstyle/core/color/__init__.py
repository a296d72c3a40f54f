"""Colours: OKLab, the main colours of a film, and RGB that its readers finish."""
