"""Measures of styles at the size that people see."""
