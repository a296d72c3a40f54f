"""Styles on photographs and clips at full size, to be judged by eye."""
