"""Restyle many films in parallel processes, and resume where an earlier run stopped."""
