"""A short film drawn in code, and what styles make of it."""
