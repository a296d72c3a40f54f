"""Predict the render time of a film on any number of cores from the measured times of its tasks."""
