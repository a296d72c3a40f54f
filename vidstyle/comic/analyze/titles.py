"""Titles that were burned into a film: lines of letters, which styles break and which fade in and out."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.regions.boxes import Rectangle
from vidstyle.regions.writing.finding import find_writing

_MEASURED_SIDE_PX = 320
"""Longer side of the copy in which titles are found."""
_MIN_COMMON_HEIGHT_RATIO, _MIN_LINE_ASPECT = 0.6, 2.0
"""Words form a line if they share this part of their height; minimum aspect of a line."""
_MIN_LINE_WIDTH_RATIO = 0.25
"""Minimum width of a title, relative to the picture's.

In a trailer of 55 s with four titles, 28 of 34 titled frames and one of 76 others are above it.
"""


def has_title(luma: np.ndarray) -> bool:
    """Whether a picture, H x W uint8, shows a line of letters."""
    factor = min(1.0, _MEASURED_SIDE_PX / max(luma.shape))
    size = tuple(max(1, round(side * factor)) for side in luma.shape[::-1])
    small = cv2.resize(luma, size, interpolation=cv2.INTER_AREA)
    words = [each.window for each in find_writing(Picture.from_array(small))]
    for word in words:
        width = sum(other.width for other in words if _is_same_line(word, other))
        if width >= max(_MIN_LINE_ASPECT * word.height, _MIN_LINE_WIDTH_RATIO * size[0]):
            return True
    return False


def _is_same_line(word: Rectangle, other: Rectangle) -> bool:
    common = min(word.bottom, other.bottom) - max(word.top, other.top)
    return common > _MIN_COMMON_HEIGHT_RATIO * max(word.height, other.height)
