"""Predicts the time of a film on other numbers of cores from the measured times of its tasks."""
