"""How a style draws faces: in ink, in tones, or in points."""

from __future__ import annotations

from enum import Enum

from vidstyle.regions.rasters import PageRaster
from vidstyle.style import Style


class Medium(Enum):
    """What the marks of a style are."""

    INK = "lines, and screens of dots or lines: no tones between ink and paper"
    TONES = "tones, with or without lines"
    POINTS = "squares or points of one tone each, which are small in faces: they draw faces themselves"

    @classmethod
    def of(cls, style: Style, raster: PageRaster) -> Medium:
        """Return the medium of a style with these rasters."""
        if raster.has_points and raster.cell and (raster.has_colors or style.lines):
            return cls.POINTS
        has_tones = style.background and not raster.is_screen
        return cls.INK if style.lines and not has_tones else cls.TONES
