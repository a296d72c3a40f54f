"""Pictures that are mixtures of two others: H x W float32 of mean 0; small."""

from __future__ import annotations

import cv2
import numpy as np

_ALIKE = 0.6
"""Pictures that correlate better are of one shot, between which nothing dissolves."""
_UNLIKE = 0.05
"""The root mean square by which two shots differ at least, 0..1."""
_MIXED = 0.4
"""A picture is a mixture of two if no more of their difference is left beside it."""
_SHARE = (0.12, 0.88)
_FOUND = 0.75
"""What correlates better with a part of the picture before is that part."""


def is_dissolve(before: np.ndarray, picture: np.ndarray, after: np.ndarray) -> bool:
    """Whether the picture lies between the two others as the pictures of a dissolve or of a fade do."""
    change = after - before
    strength = float(np.sqrt(np.mean(change**2)))
    if strength < _UNLIKE or (_likeness(before, after) > _ALIKE and not _fades(before, after)):
        return False
    share = float(np.mean((picture - before) * change)) / strength**2
    if not _SHARE[0] < share < _SHARE[1]:
        return False
    rest = picture - before - share * change
    return float(np.sqrt(np.mean(rest**2))) < _MIXED * strength


def is_moved(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether the middle of one is found in the other, as strong as it is: then the camera has turned."""
    if _fades(before, after):
        return False
    down, across = before.shape[0] // 4, before.shape[1] // 4
    for one, other in ((before, after), (after, before)):
        middle = np.ascontiguousarray(one[down:-down, across:-across])
        if cv2.matchTemplate(other, middle, cv2.TM_CCOEFF_NORMED).max() > _FOUND:
            return True
    return False


def _fades(before: np.ndarray, after: np.ndarray) -> bool:
    """Whether one picture has much less contrast than the other."""
    lower, higher = sorted((float(before.std()), float(after.std())))
    return lower < 0.6 * higher


def _likeness(one: np.ndarray, other: np.ndarray) -> float:
    """The correlation of two pictures of mean 0; 0 where one is blank."""
    energy = float(np.sqrt(np.mean(one**2) * np.mean(other**2)))
    return float(np.mean(one * other)) / energy if energy > 1e-4 else 0.0
