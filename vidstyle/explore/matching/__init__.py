"""Styles that match a picture: distances between looks, a search, and tuning."""
