"""Paper: the size of a page in pixels, and its margins, gutters and borders."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Literal

from vidstyle.comic.moment import Box, Rectangle
from vidstyle.errors import UsageError

LayoutKind = Literal["classic", "dynamic", "manga", "grid"]
"""Straight gutters, slanted ones, slanted ones from right to left with bleed, and a regular grid."""
SLANTED = "dynamic", "manga"

MILLIMETRES = {
    "a3": (297.0, 420.0),
    "a4": (210.0, 297.0),
    "a5": (148.0, 210.0),
    "letter": (215.9, 279.4),
    "square": (210.0, 210.0),
}
"""Width and height of the named paper sizes in portrait orientation."""

STRIPS = {"strip": 1080, "webtoon": 800}
"""Widths of the named strips for phones in pixels."""

DPI = 150
MARGIN = 10.0
GUTTER = 3.0
ROW_GUTTER = 5.0
"""Millimetres; larger than the gutter between columns, so that the reading order is clear."""
BORDER = 2.16
"""Width of panel borders in points."""

_POINTS = 72.0
INCH = 25.4
"""Millimetres."""
_USUAL = 210.0
"""Width in millimetres below which margins and gutters shrink in proportion."""
_LEAST, _MOST = 64, 30000
"""Range of a page's sides in pixels."""
MAX_PAGE_PIXELS = 70_000_000
"""Maximum number of pixels that are drawn as one picture: A3 at 600 dots per inch."""


@dataclass(frozen=True)
class Paper:
    """A page; all lengths in pixels.

    Attributes:
        width, height: of the page after trimming; the height of a strip is 0: as much as it needs.
        dpi: pixels per inch.
        margin: from the page's edge to the panels.
        gutter, row_gutter: between columns and between rows of panels.
        border: width of the line around a panel, inside its rectangle.
    """

    width: int
    height: int
    dpi: float
    margin: int
    gutter: int
    row_gutter: int
    border: int

    @property
    def is_strip(self) -> bool:
        """Whether it is one column of any height."""
        return self.height == 0

    @property
    def safe(self) -> Box:
        """The part of the page in which words are, so that none is trimmed where pictures bleed."""
        room = self.margin / 2
        bottom = math.inf if self.is_strip else self.height - room
        return Box(room, room, self.width - room, bottom)

    @property
    def inside(self) -> Rectangle:
        """The page without its margins; that of a strip has no height."""
        bottom = max(self.margin, self.height - self.margin)
        return Rectangle(self.margin, self.margin, self.width - self.margin, bottom)


def paper(size: str = "a4", dpi: float = DPI, landscape: bool = False, border: float = BORDER) -> Paper:
    """The paper of a size.

    Args:
        size: a name of `MILLIMETRES` or `STRIPS`, or WIDTHxHEIGHT in pixels or, with "mm" behind it, in
            millimetres.
        dpi: pixels per inch.
        landscape: landscape orientation for a named size.
        border: points.

    Raises:
        UsageError: there is no such size.

    >>> page = paper("a4")
    >>> page.width, page.height, page.margin, page.gutter, page.border
    (1240, 1754, 59, 18, 4)
    >>> paper("1920x1080").width
    1920
    """
    if not 10 <= dpi <= 2400:
        raise UsageError("--dpi", f"{dpi:g} is outside 10 to 2400")
    width, height = _sides(size.strip().lower(), dpi, landscape)
    scale = min(1.0, min(width, height or width) / _pixels(_USUAL, dpi))
    margin, gutter, row_gutter = (round(_pixels(each, dpi) * scale) for each in (MARGIN, GUTTER, ROW_GUTTER))
    line = round(border * dpi / _POINTS) or int(border > 0)
    return Paper(width, height, dpi, margin, gutter, row_gutter, line)


def _sides(size: str, dpi: float, landscape: bool) -> tuple[int, int]:
    """Width and height in pixels; the height of a strip is 0."""
    if size in STRIPS:
        return STRIPS[size], 0
    sides = MILLIMETRES.get(size)
    if sides:
        width, height = (round(_pixels(side, dpi)) for side in (sides[::-1] if landscape else sides))
    else:
        found = re.fullmatch(r"(\d+(?:\.\d+)?)\s*[x×]\s*(\d+(?:\.\d+)?)\s*(px|mm)?", size)
        if not found:
            names = ", ".join([*MILLIMETRES, *STRIPS])
            raise UsageError(size, "is not a size of paper", f"give {names}, 1200x1800 or 210x297mm")
        number = [float(side) for side in found.groups()[:2]]
        width, height = (round(_pixels(side, dpi) if found[3] == "mm" else side) for side in number)
    if min(width, height) < _LEAST or max(width, height) > _MOST:
        remedy = f"{_LEAST} to {_MOST} pixels a side are possible"
        raise UsageError(size, f"is a page of {width}x{height} pixels at {dpi:g} dpi", remedy)
    return width, height


def _pixels(millimetres: float, dpi: float) -> float:
    return millimetres * dpi / INCH
