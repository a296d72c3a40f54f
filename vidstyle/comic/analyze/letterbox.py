"""The area of a picture inside its black bars."""

from __future__ import annotations

import cv2
import numpy as np

_MAX_BAR_LEVEL, _MAX_BAR_RANGE = 30, 12
"""Lightest pixel of a bar, and largest difference within one of its lines, of 255."""
_MIN_BAR_SHARE, _MAX_BAR_SHARE = 0.01, 0.35
"""Range of the share of the picture's side that a bar takes."""

_MAX_RIM_SHARE, _MAX_RIM_LIGHT_RATIO, _MIN_RIM_DARK_SHARE = 0.02, 0.6, 0.75
"""Maximum share of a side of the picture that a rim takes, maximum light of its pixels relative to the
picture next to them, and minimum share of such pixels in a line: a dark object at the edge covers fewer.
Scaling mixes narrow black bars with the picture."""


def content_area(color: np.ndarray, is_photograph: bool = False) -> tuple[slice, slice]:
    """Return the rows and columns of a picture inside its black bars; all of them if there are no bars.

    Args:
        color: H x W x 3 uint8.
        is_photograph: whether each side may have its own bar. The bars of a film are equal at opposite sides,
            and a dark side is not one; a narrow dark rim may be at one side only.
    """
    red, green, blue = cv2.split(color)
    luma = cv2.max(cv2.max(red, green), blue)
    return _find_content_span(luma, 1, is_photograph), _find_content_span(luma, 0, is_photograph)


def _find_content_span(luma: np.ndarray, axis: int, is_photograph: bool) -> slice:
    # Fifty times as fast as `cv2.reduce` across.
    brightest, darkest = luma.max(axis=axis).astype(int), luma.min(axis=axis).astype(int)
    shown = np.flatnonzero((brightest > _MAX_BAR_LEVEL) | (brightest - darkest > _MAX_BAR_RANGE))
    count = len(brightest)
    bars = (int(shown[0]), count - 1 - int(shown[-1])) if len(shown) else (0, 0)
    bars = bars if is_photograph else (min(bars),) * 2
    # One more line, as scaling has mixed bar and picture there.
    first, last = (bar + 1 if _MIN_BAR_SHARE * count <= bar <= _MAX_BAR_SHARE * count else 0 for bar in bars)
    lines = luma if axis == 1 else luma.T
    return slice(max(first, _measure_rim(lines)), count - max(last, _measure_rim(lines[::-1])))


def _measure_rim(lines: np.ndarray) -> int:
    """Return the number of lines at the start that are a dark rim; `lines`: N x M uint8, parallel to it."""
    reach = max(2, round(_MAX_RIM_SHARE * len(lines)))
    if len(lines) <= reach:
        return 0
    beside = lines[reach]
    lit = beside > _MAX_BAR_LEVEL
    if not lit.any():
        return 0
    dark_shares = (lines[:reach, lit] < _MAX_RIM_LIGHT_RATIO * beside[lit]).mean(axis=1)
    dark = dark_shares >= _MIN_RIM_DARK_SHARE
    return int(np.flatnonzero(dark)[-1]) + 2 if dark[0] else 0
