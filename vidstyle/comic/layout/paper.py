"""Paper: the size of a page in pixels, and its margins, gutters and borders."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Literal

from vidstyle.errors import UsageError
from vidstyle.regions.boxes import Box, Rectangle

LayoutKind = Literal["classic", "dynamic", "manga", "grid"]
"""Straight gutters, slanted ones, slanted ones from right to left with bleed, and a regular grid."""
SLANTED_LAYOUTS = "dynamic", "manga"
"""The kinds with slanted gutters."""

PAPER_SIZES_MM = {
    "a3": (297.0, 420.0),
    "a4": (210.0, 297.0),
    "a5": (148.0, 210.0),
    "letter": (215.9, 279.4),
    "square": (210.0, 210.0),
}
"""Width and height of the named paper sizes in portrait orientation."""

SCREEN_SIZES_PX = {"screen": (1800, 1100)}
"""Width and height of the named pages for windows of a browser."""

STRIP_WIDTHS_PX = {"strip": 1080, "webtoon": 800}
"""Widths of the named strips for phones."""

DEFAULT_DPI, PRINT_DPI = 150, 300
"""Resolution for screens and for print: dots of a style must not form a second screen with the printer's."""
_MIN_SIDE_PX, _MAX_SIDE_PX = 64, 30000
"""Range of a page's sides."""
MARGIN_MM, GUTTER_MM = 10.0, 3.0
ROW_GUTTER_MM = 5.0
"""Larger than the gutter between columns, so that the reading order is clear; see `widen_stack_gutters`."""
_FULL_MARGIN_WIDTH_MM = 210.0
"""Page width below which margins and gutters shrink in proportion."""
BORDER_POINTS = 2.16
"""Width of panel borders."""
_POINTS_PER_INCH, MM_PER_INCH = 72.0, 25.4
MAX_PAGE_PIXELS = 70_000_000
"""Maximum number of pixels that are drawn as one picture: A3 at 600 dots per inch."""


@dataclass(frozen=True)
class Paper:
    """A page; all lengths in pixels.

    Attributes:
        width, height: of the page after trimming; the height of a strip is 0: as high as necessary.
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
        """The part of the page that may contain text, which is not trimmed off if pictures bleed."""
        room = self.margin / 2
        bottom = math.inf if self.is_strip else self.height - room
        return Box(room, room, self.width - room, bottom)

    @property
    def inside(self) -> Rectangle:
        """The page without its margins; the inside of a strip has no height."""
        bottom = max(self.margin, self.height - self.margin)
        return Rectangle(self.margin, self.margin, self.width - self.margin, bottom)


def paper(
    size: str = "a4", dpi: float = DEFAULT_DPI, landscape: bool = False, border: float = BORDER_POINTS
) -> Paper:
    """Return the paper of a size.

    Args:
        size: a name of `PAPER_SIZES_MM`, `SCREEN_SIZES_PX` or `STRIP_WIDTHS_PX`, or WIDTHxHEIGHT in pixels,
            or in millimetres if "mm" follows.
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
    scale = min(1.0, min(width, height or width) / _pixels(_FULL_MARGIN_WIDTH_MM, dpi))
    margin, gutter, row_gutter = (
        round(_pixels(each, dpi) * scale) for each in (MARGIN_MM, GUTTER_MM, ROW_GUTTER_MM)
    )
    line = round(border * dpi / _POINTS_PER_INCH) or int(border > 0)
    return Paper(width, height, dpi, margin, gutter, row_gutter, line)


def _sides(size: str, dpi: float, landscape: bool) -> tuple[int, int]:
    """Return width and height in pixels; the height of a strip is 0."""
    if size in STRIP_WIDTHS_PX:
        return STRIP_WIDTHS_PX[size], 0
    if size in SCREEN_SIZES_PX:
        return SCREEN_SIZES_PX[size]
    sides = PAPER_SIZES_MM.get(size)
    if sides:
        width, height = (round(_pixels(side, dpi)) for side in (sides[::-1] if landscape else sides))
    else:
        found = re.fullmatch(r"(\d+(?:\.\d+)?)\s*[x×]\s*(\d+(?:\.\d+)?)\s*(px|mm)?", size)
        if not found:
            names = ", ".join([*PAPER_SIZES_MM, *SCREEN_SIZES_PX, *STRIP_WIDTHS_PX])
            raise UsageError(size, "is not a paper size", f"give {names}, 1200x1800 or 210x297mm")
        number = [float(side) for side in found.groups()[:2]]
        width, height = (round(_pixels(side, dpi) if found[3] == "mm" else side) for side in number)
    if min(width, height) < _MIN_SIDE_PX or max(width, height) > _MAX_SIDE_PX:
        remedy = f"each side must be {_MIN_SIDE_PX} to {_MAX_SIDE_PX} pixels"
        raise UsageError(size, f"is a page of {width}x{height} pixels at {dpi:g} dpi", remedy)
    return width, height


def _pixels(millimetres: float, dpi: float) -> float:
    return millimetres * dpi / MM_PER_INCH
