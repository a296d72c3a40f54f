"""Searches for the best bank for a filter, and explains what no bank reproduces."""
