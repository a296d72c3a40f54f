"""Screens of nine tiles from which a user chooses, and the taste learned from the choices."""
