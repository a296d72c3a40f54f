"""How a style draws faces: in ink, in tones, or in points."""

from __future__ import annotations

from enum import Enum

from vidstyle.block import rgb_from_text
from vidstyle.regions.rasters import PageRaster
from vidstyle.style import Style

POINTS_SHARE = 0.25
"""How much of the features of faces is taken off for styles of squares or points.

These draw faces themselves and raise their contrast, so eyes would become dark bars. Tuned on 16 faces of
92 to 196 lines in pixel.
"""


class Medium(Enum):
    """What the marks of a style are."""

    INK = "lines, and screens of dots or lines: no tones between ink and paper"
    COLORED_INK = "dark lines over a screen of several inks: they draw faces themselves, which are corrected"
    TONES = "tones, with or without lines"
    POINTS = "squares or points of one tone each, which are small in faces: they draw faces themselves"

    @classmethod
    def of(cls, style: Style, raster: PageRaster) -> Medium:
        """Return the medium of a style with these rasters."""
        if raster.has_points and raster.cell and (raster.has_colors or style.lines):
            return cls.POINTS
        has_tones = style.background and not raster.is_screen
        if not style.lines or has_tones:
            return cls.TONES
        ink, paper = (sum(rgb_from_text(each)) for each in (style.ink, style.paper))
        return cls.COLORED_INK if raster.has_colors and ink < paper else cls.INK

    @property
    def lifted_share(self) -> float:
        """How much of the features of faces is taken off before the style draws the face, 0..1."""
        return {Medium.COLORED_INK: 0.0, Medium.POINTS: POINTS_SHARE}.get(self, 1.0)
