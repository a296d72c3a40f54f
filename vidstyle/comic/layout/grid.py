"""A regular grid: panels of one size, two beside each other on an upright page."""

from __future__ import annotations

import math

from vidstyle.comic.layout.paper import Paper
from vidstyle.comic.moment import Rectangle

_WIDE = 1.4
"""Width by height of a panel that is aimed at."""


def grid_places(count: int, pages: int, paper: Paper) -> list[tuple[int, Rectangle]]:
    """Page and rectangle of each panel, in reading order; panels of a last row that is not full are wider."""
    inside, placed = paper.inside, list[tuple[int, Rectangle]]()
    for page in range(pages):
        left = count * (page + 1) // pages - count * page // pages
        columns = max(1, round(math.sqrt(left * inside.width / inside.height / _WIDE)))
        rows = math.ceil(left / columns)
        for row in range(rows):
            top, bottom = _span(inside.top, inside.bottom, row, rows, paper.row_gutter)
            beside = min(columns, left - row * columns)
            for column in range(beside):
                start, end = _span(inside.left, inside.right, column, beside, paper.gutter)
                placed.append((page, Rectangle(start, top, end, bottom)))
    return placed


def _span(start: int, end: int, number: int, count: int, gutter: int) -> tuple[int, int]:
    """The ends of one of so many equal parts."""
    step = (end - start + gutter) / count
    return start + round(number * step), start + round((number + 1) * step) - gutter
