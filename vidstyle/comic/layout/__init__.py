"""Panels on paper: sizes, rows, pages, strips, storyboards and crops."""
