"""Marks of paint and print: where they lie, their directions, and their shapes."""
