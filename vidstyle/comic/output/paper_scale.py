"""The size of a style's marks on paper, and the resolution at which panels are drawn."""

from __future__ import annotations

from dataclasses import replace

from vidstyle.comic.layout.paper import MM_PER_INCH
from vidstyle.style import Style
from vidstyle.style.resolve import resolve

DEFAULT_STYLE_HEIGHT_PX = 720
"""Reference height of styles that declare none."""
STYLE_HEIGHT_MM = 63.0
"""Height on paper that corresponds to a style's reference height.

It was tuned on panels of four films: with 90 mm, faces of less than 12 mm lost their eyes.
"""
MIN_DRAWN_DPI, MAX_REDUCTION_FACTOR = 300.0, 2.0
"""Resolution at which panels are drawn at least, as lines and dots are no finer than pixels; and the maximum
factor by which they are reduced to the resolution of the page."""


def scale_to_paper(style: Style, height: int, width: int, dpi: float) -> Style:
    """Return the style with lengths that are constant on paper, independent of the picture's size.

    The reference height of a style corresponds to 63 mm: with 720 lines, 5 pixels are 0.44 mm in panels of
    every size and at every resolution.

    Args:
        style: not changed.
        height, width: of the picture to restyle, in pixels.
        dpi: pixels per inch.
    """
    printed = STYLE_HEIGHT_MM * dpi / MM_PER_INCH
    lines = style.height or DEFAULT_STYLE_HEIGHT_PX
    # A still needs no temporal smoothing.
    return replace(style, height=min(height, width) * lines / printed, steady=0.0)


def reduction_factor(style: Style, dpi: float) -> float:
    """Return the factor by which a panel is drawn larger than it is shown, 1 or more.

    It is 1 for styles of squares, letters or points of one tone, which would be blended.

    Args:
        style: of the panel.
        dpi: pixels per inch of the panel that is shown.
    """
    if _has_points(style):
        return 1.0
    return min(MAX_REDUCTION_FACTOR, max(1.0, MIN_DRAWN_DPI / dpi))


def _has_points(style: Style) -> bool:
    """Whether all marks of a style are points, squares or letters of one tone."""
    side = DEFAULT_STYLE_HEIGHT_PX
    steps = (step for layer in resolve(style, side, side).values() for step in layer)
    rasters = [step.block.raster_for(step.values) for step in steps if step.block is not None]
    marks = [each for each in rasters if each]
    return bool(marks) and all(each.has_points for each in marks)
