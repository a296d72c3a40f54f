"""Flat rectangles: parts of a picture that were overwritten with one colour."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from vidstyle.regions.boxes import Box

_MAX_FLAT_LEVELS, _MAX_FLAT_RANGE_LEVELS = 3, 12
"""Maximum difference of neighbouring pixels of a flat part, and of all its pixels, of 255."""
_MIN_BOX_SHARE, _MIN_BOX_SIDE_PX, _MIN_FILLED_SHARE = 0.01, 12, 0.93
"""Minimum share of the picture and minimum side of a flat rectangle, and how much of its box it fills."""
_BORDER_PX, _MIN_BORDER_LEVELS, _MIN_BORDER_SHARE = 5, 16, 0.8
"""Distance at which its surroundings differ by these levels, of 255, on this share of each side."""
_NEARBY_SECONDS, _MIN_APART_SECONDS = 0.75, 0.1
"""Time within which a rectangle that is no damage is seen again, and from which it counts as seen again."""
_MIN_OVERLAP_SHARE = 0.5
"""Overlap of two rectangles, relative to their union, from which they are the same one."""


def find_flat_box(luma: np.ndarray) -> Box | None:
    """Return the largest flat rectangle of a picture, H x W uint8, that differs from all around it."""
    steps = cv2.morphologyEx(luma, cv2.MORPH_GRADIENT, np.ones((3, 3), np.uint8))
    _, labels, stats, _ = cv2.connectedComponentsWithStats((steps <= _MAX_FLAT_LEVELS).astype(np.uint8))
    areas = stats[1:, cv2.CC_STAT_AREA]
    large = 1 + np.flatnonzero(areas >= _MIN_BOX_SHARE * luma.size)
    for number in large[np.argsort(-areas[large - 1], kind="stable")]:
        left, top, width, height, area = (int(each) for each in stats[number])
        if min(width, height) < _MIN_BOX_SIDE_PX or area < _MIN_FILLED_SHARE * width * height:
            continue
        inside = luma[top : top + height, left : left + width][
            labels[top : top + height, left : left + width] == number
        ]
        is_one_tone = int(inside.max()) - int(inside.min()) <= _MAX_FLAT_RANGE_LEVELS
        if is_one_tone and _stands_out(luma, left, top, width, height):
            return Box(left, top, left + width, top + height)
    return None


def _stands_out(luma: np.ndarray, left: int, top: int, width: int, height: int) -> bool:
    """Whether a rectangle has surroundings on all four sides, which differ from it."""
    right, bottom, away = left + width, top + height, _BORDER_PX
    if left < away or top < away or right + away > luma.shape[1] or bottom + away > luma.shape[0]:
        return False
    level = float(np.median(luma[top:bottom, left:right]))
    around = (
        luma[top - away, left:right],
        luma[bottom + away - 1, left:right],
        luma[top:bottom, left - away],
        luma[top:bottom, right + away - 1],
    )
    return all(
        float(np.mean(np.abs(side - level) >= _MIN_BORDER_LEVELS)) >= _MIN_BORDER_SHARE for side in around
    )


def is_sudden(box: Box | None, time: float, boxes: Sequence[tuple[float, Box | None]]) -> bool:
    """Whether a flat rectangle is in no other frame near its own, of which there is at least one.

    Signs, windows and title cards last; a part that was overwritten is seen for a moment.

    Args:
        box: in the frame; or None.
        time: of the frame in seconds.
        boxes: times and rectangles of the film's candidates.
    """
    near = [each for at, each in boxes if _MIN_APART_SECONDS < abs(at - time) <= _NEARBY_SECONDS]
    return box is not None and bool(near) and not any(each and _is_same(box, each) for each in near)


def _is_same(one: Box, other: Box) -> bool:
    shared = one.intersection(other).area
    return shared >= _MIN_OVERLAP_SHARE * (one.area + other.area - shared)
