"""Contact sheets: whole pictures in a grid, each with its timecode."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

from vidstyle.comic.layout.layout import PageLayout, Panel
from vidstyle.comic.layout.paper import Paper
from vidstyle.comic.moment import Box, Moment, Rectangle
from vidstyle.comic.output.sheet import Label
from vidstyle.errors import UsageError

COLUMNS, COLUMNS_WIDE, COLUMNS_STRIP = 3, 5, 2
"""Pictures in a row of a portrait page, of a landscape page and of a strip."""

_LINE = 1.6
"""Height of the line below each picture, in font sizes."""


def contact_sheet(moments: Sequence[Moment], paper: Paper, size: int, head: int = 0) -> PageLayout:
    """Lay out pictures in equal cells, in chronological order.

    Args:
        moments: in chronological order.
        paper: of each page.
        size: font size in pixels.
        head: pixels to leave free at the top of each page.

    Raises:
        UsageError: a page has no room for a row.
    """
    wide = paper.width > 1.2 * paper.height
    columns = COLUMNS_STRIP if paper.is_strip else COLUMNS_WIDE if wide else COLUMNS
    width = (paper.inside.width - (columns - 1) * paper.gutter) // columns
    high = round(width / median(moment.shape[1] / moment.shape[0] for moment in moments))
    step = high + round(_LINE * size) + paper.row_gutter
    rows = math.ceil(len(moments) / columns)
    if not paper.is_strip:
        rows = min(rows, (paper.inside.height - head + paper.row_gutter) // step)
    if rows < 1 or width < 1:
        raise UsageError("storyboard", "the page is too small for a picture", "give a larger --size")
    each = rows * columns
    panels = []
    for number, moment in enumerate(moments):
        row, column = divmod(number % each, columns)
        left, top = paper.margin + column * (width + paper.gutter), paper.margin + head + row * step
        panels.append(_panel(number, moment, number // each, Rectangle(left, top, left + width, top + high)))
    height = head + 2 * paper.margin + rows * step if paper.is_strip else paper.height
    return PageLayout(tuple(panels), ((paper.width, height),) * math.ceil(len(moments) / each), 0.0)


def _panel(number: int, moment: Moment, page: int, cell: Rectangle) -> Panel:
    """The whole picture, at the bottom of its cell and centred horizontally."""
    height, width = moment.shape
    factor = min(cell.width / width, cell.height / height)
    wide, high = max(1, round(width * factor)), max(1, round(height * factor))
    left, top = cell.left + (cell.width - wide) // 2, cell.bottom - high
    place = Rectangle(left, top, left + wide, top + high)
    return Panel(number, page, place, place, Box(0, 0, width, height))


def time_labels(layout: PageLayout, moments: Sequence[Moment], size: int) -> list[list[Label]]:
    """The timecodes below the pictures of each page."""
    pages: list[list[Label]] = [[] for _ in layout.sizes]
    for panel in layout.panels:
        left, _, right, bottom = panel.rectangle
        time = timecode(moments[panel.moment].time)
        pages[panel.page].append(Label(time, (left + right) / 2, bottom + 1.15 * size, size))
    return pages


def timecode(seconds: float) -> str:
    """A time as hours, minutes and seconds, rounded to tenths.

    >>> timecode(3.25), timecode(3725.96)
    ('0:03.2', '1:02:06.0')
    """
    tenths = round(seconds * 10)
    minutes, tenths = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    rest = f"{tenths / 10:04.1f}"
    return f"{hours}:{minutes:02}:{rest}" if hours else f"{minutes}:{rest}"
