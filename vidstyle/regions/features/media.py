"""How a style draws faces: in ink, in tones, in light lines or in squares."""

from __future__ import annotations

from enum import Enum

from vidstyle.block import rgb_from_text
from vidstyle.regions.rasters import PageRaster
from vidstyle.style import Style

MIN_LIGHT_INK = 0.5
"""Mean of red, green and blue of an ink that is light, 0..1."""


class Medium(Enum):
    """What the marks of a style are."""

    INK = "lines, and screens of dots or lines: no tones between ink and paper, and bare lit skin"
    SCREEN = "the same, with marks on lit skin too"
    TONES = "tones, with or without lines"
    OUTLINES = "light lines over darker tones"
    SQUARES = "coloured squares, which are smaller in faces"

    @classmethod
    def of(cls, style: Style, raster: PageRaster) -> Medium:
        """Return the medium of a style with these rasters."""
        if raster.has_points and raster.cell and raster.has_colors:
            return cls.SQUARES
        if style.lines and (raster.is_screen or not style.background):
            is_full = raster.has_points or (style.background and not raster.has_dots)
            return cls.SCREEN if is_full else cls.INK
        return cls.OUTLINES if sum(rgb_from_text(style.ink)) > 3 * MIN_LIGHT_INK else cls.TONES

    @property
    def is_ink(self) -> bool:
        """Whether there are no tones between ink and paper."""
        return self in (Medium.INK, Medium.SCREEN)
