"""A regular grid: panels of one size, two next to each other on a portrait page."""

from __future__ import annotations

import math

from vidstyle.comic.layout.paper import Paper
from vidstyle.regions.boxes import Rectangle

_WANTED_PANEL_ASPECT = 1.4
"""Width divided by height of the panels that the grid aims at."""


def place_grid(count: int, pages: int, paper: Paper) -> list[tuple[int, Rectangle]]:
    """Return page and rectangle of each panel, in reading order; panels of an incomplete row are wider."""
    inside, placed = paper.inside, list[tuple[int, Rectangle]]()
    for page in range(pages):
        remaining = count * (page + 1) // pages - count * page // pages
        columns = max(1, round(math.sqrt(remaining * inside.width / inside.height / _WANTED_PANEL_ASPECT)))
        rows = math.ceil(remaining / columns)
        for row in range(rows):
            top, bottom = _span(inside.top, inside.bottom, row, rows, paper.row_gutter)
            row_columns = min(columns, remaining - row * columns)
            for column in range(row_columns):
                start, end = _span(inside.left, inside.right, column, row_columns, paper.gutter)
                placed.append((page, Rectangle(start, top, end, bottom)))
    return placed


def _span(start: int, end: int, number: int, count: int, gutter: int) -> tuple[int, int]:
    """Return the ends of one of `count` equal parts."""
    step = (end - start + gutter) / count
    return start + round(number * step), start + round((number + 1) * step) - gutter
