"""What a panel shows, on the page, and what else it could show."""

from __future__ import annotations

from collections.abc import Iterator

from vidstyle.comic.crop import main_face
from vidstyle.comic.moment import Box, Moment
from vidstyle.comic.paper import Rectangle

_SHIFTS = ((0, -0.5), (0, -1), (-0.5, 0), (0.5, 0), (-1, 0), (1, 0), (0, 0.5))
"""Where else a panel may look, in parts of the way to the edge of the picture or of what must be seen."""


def within_border(rectangle: Rectangle, border: int) -> Rectangle:
    """What a border of so many pixels leaves of a panel."""
    left, top, right, bottom = rectangle
    return Rectangle(left + border, top + border, right - border, bottom - border)


def on_page(box: Box, window: Box, picture: Rectangle) -> Box:
    """A box of a moment's picture as it is on the page, as far as it can be seen."""
    seen, factor = box.intersection(window), picture.width / max(window.width, 1e-6)
    moved = Box(
        seen.left - window.left, seen.top - window.top, seen.right - window.left, seen.bottom - window.top
    )
    scaled = moved.scaled(factor)
    left, top = picture.left, picture.top
    return Box(scaled.left + left, scaled.top + top, scaled.right + left, scaled.bottom + top)


def elsewhere(window: Box, moment: Moment) -> Iterator[Box]:
    """Other windows of the same size in which the main face, or without one what is salient, is as whole."""
    height, width = moment.shape
    kept = (main_face(moment) or moment.salience).intersection(window)
    left, right = max(0.0, kept.right - window.width), min(width - window.width, kept.left)
    top, bottom = max(0.0, kept.bottom - window.height), min(height - window.height, kept.top)
    for x, y in _SHIFTS:
        across = x * (right - window.left if x > 0 else window.left - left)
        down = y * (bottom - window.top if y > 0 else window.top - top)
        if abs(across) + abs(down) >= 1 and left <= right and top <= bottom:
            yield Box(window.left + across, window.top + down, window.right + across, window.bottom + down)
