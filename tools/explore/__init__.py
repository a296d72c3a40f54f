"""Fits and measures the explorer: its score, the measure of `--like`, its sheet, a simulated user."""
