"""Contact sheets: whole pictures in a grid, each with its timecode."""

from __future__ import annotations

import math
from collections.abc import Sequence
from statistics import median

from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.layout import PageLayout, Panel
from vidstyle.comic.layout.paper import Paper
from vidstyle.comic.output.sheet import Label
from vidstyle.errors import UsageError
from vidstyle.regions.boxes import Box, Rectangle

PORTRAIT_COLUMNS, LANDSCAPE_COLUMNS, STRIP_COLUMNS = 3, 5, 2
"""Pictures in a row of a portrait page, of a landscape page and of a strip."""

_TIME_LINE_HEIGHT = 1.6
"""Height of the line below each picture, in font sizes."""


def contact_sheet(key_frames: Sequence[KeyFrame], paper: Paper, size: int, head: int = 0) -> PageLayout:
    """Lay out pictures in equal cells, in chronological order.

    Args:
        key frames: in chronological order.
        paper: of each page.
        size: font size in pixels.
        head: pixels to leave free at the top of each page.

    Raises:
        UsageError: a page has no room for a row.
    """
    wide = paper.width > 1.2 * paper.height
    columns = STRIP_COLUMNS if paper.is_strip else LANDSCAPE_COLUMNS if wide else PORTRAIT_COLUMNS
    width = (paper.inside.width - (columns - 1) * paper.gutter) // columns
    high = round(width / median(key_frame.shape[1] / key_frame.shape[0] for key_frame in key_frames))
    step = high + round(_TIME_LINE_HEIGHT * size) + paper.row_gutter
    rows = math.ceil(len(key_frames) / columns)
    if not paper.is_strip:
        rows = min(rows, (paper.inside.height - head + paper.row_gutter) // step)
    if rows < 1 or width < 1:
        raise UsageError("storyboard", "page too small for a picture", "give a larger --size")
    each = rows * columns
    panels = []
    for number, key_frame in enumerate(key_frames):
        row, column = divmod(number % each, columns)
        left, top = paper.margin + column * (width + paper.gutter), paper.margin + head + row * step
        panels.append(
            _panel(number, key_frame, number // each, Rectangle(left, top, left + width, top + high))
        )
    height = head + 2 * paper.margin + rows * step if paper.is_strip else paper.height
    return PageLayout(tuple(panels), ((paper.width, height),) * math.ceil(len(key_frames) / each), 0.0)


def _panel(number: int, key_frame: KeyFrame, page: int, cell: Rectangle) -> Panel:
    """Return the whole picture, at the bottom of its cell and centred horizontally."""
    height, width = key_frame.shape
    factor = min(cell.width / width, cell.height / height)
    wide, high = max(1, round(width * factor)), max(1, round(height * factor))
    left, top = cell.left + (cell.width - wide) // 2, cell.bottom - high
    place = Rectangle(left, top, left + wide, top + high)
    return Panel(number, page, place, place, Box(0, 0, width, height))


def time_labels(layout: PageLayout, key_frames: Sequence[KeyFrame], size: int) -> list[list[Label]]:
    """Return the timecodes below the pictures of each page."""
    pages: list[list[Label]] = [[] for _ in layout.sizes]
    for panel in layout.panels:
        left, _, right, bottom = panel.rectangle
        time = format_timecode(key_frames[panel.key_frame].time)
        pages[panel.page].append(Label(time, (left + right) / 2, bottom + 1.15 * size, size))
    return pages


def format_timecode(seconds: float) -> str:
    """Format a time as hours, minutes and seconds, rounded to tenths.

    >>> format_timecode(3.25), format_timecode(3725.96)
    ('0:03.2', '1:02:06.0')
    """
    tenths = round(seconds * 10)
    minutes, tenths = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    rest = f"{tenths / 10:04.1f}"
    return f"{hours}:{minutes:02}:{rest}" if hours else f"{minutes}:{rest}"
