"""Styles that nobody has designed: made at random by rules, filtered, scored, and varied."""
