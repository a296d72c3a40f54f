"""How a style draws: in ink alone, in ink over tones, in tones, in light, in points or in grain."""

from __future__ import annotations

from enum import Enum
from itertools import pairwise

from vidstyle.block import rgb_from_text
from vidstyle.regions.rasters import PageRaster
from vidstyle.style import Style

FACE_RATIOS = 0.12, 0.18
"""Heights of faces relative to the picture's shorter side. Features are lifted completely up to the first;
from the second on not at all, as the style draws them well itself. On 20 faces of 80 to 220 of 1080 lines in
comic, ink, engraving and thermal."""


class Medium(Enum):
    """What the marks of a style are."""

    INK = "lines, and screens of dots or lines: no tones between ink and paper"
    INK_OVER_TONES = "lines over continuous tones"
    TONES = "no lines"
    LIGHT_LINES = "lines lighter than their ground"
    POINTS = "points, squares and letters, which are small in faces"
    GRAIN = "grain of paper, which a threshold covers or leaves bare"

    @classmethod
    def of(cls, style: Style, raster: PageRaster) -> Medium:
        """Return the medium of a style with these rasters."""
        if raster.has_points:
            return cls.POINTS
        if not style.lines:
            return cls.GRAIN if _has_grain(style) else cls.TONES
        if sum(rgb_from_text(style.ink)) > sum(rgb_from_text(style.paper)):
            return cls.LIGHT_LINES
        return cls.INK_OVER_TONES if style.background and not raster.is_screen else cls.INK

    def lifted_share(self, size_ratio: float) -> float:
        """Return how much of the features of a face is lifted, 0..1.

        Args:
            size_ratio: the height of the face relative to the picture's shorter side.
        """
        if self in (Medium.POINTS, Medium.GRAIN):
            return 0.0
        whole, none = FACE_RATIOS
        return min(1.0, max(0.0, (none - size_ratio) / (none - whole)))


def _has_grain(style: Style) -> bool:
    """Return whether grain is thresholded: lines over it would look like strokes of a pen."""
    blocks = [step.block for step in style.background]
    return ("noise", "soft_threshold") in pairwise(blocks)
