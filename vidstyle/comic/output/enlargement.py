"""Sharpening of enlarged pictures, whose eyes and outlines are too soft for a style to draw."""

from __future__ import annotations

import cv2
import numpy as np

_AMOUNT_PER_FACTOR, _MAX_AMOUNT = 1.5, 1.5
"""Amount of the unsharp mask for each factor of enlargement beyond 1, and its maximum."""
_DEVIATION_RATIO = 2.0
"""Standard deviation of its Gaussian in pixels of the source, about the blur of the source."""
_REACH_RATIO, _MAX_OVERSHOOT_LEVELS = 2, 6
"""Sharpened luma stays between the darkest and the brightest pixel within this distance, in standard
deviations, give or take this many levels of 255, so that edges get no rims."""


def sharpen_enlarged(color: np.ndarray, factor: float) -> np.ndarray:
    """Return an enlarged picture, H x W x 3 uint8, with edges as steep as they are in its source.

    Args:
        color: the picture.
        factor: of the enlargement, above 1.
    """
    lab = cv2.cvtColor(color, cv2.COLOR_RGB2LAB)
    luma = np.ascontiguousarray(lab[..., 0])
    amount = min(_MAX_AMOUNT, _AMOUNT_PER_FACTOR * (factor - 1))
    deviation = _DEVIATION_RATIO * factor
    sharp = cv2.addWeighted(luma, 1 + amount, cv2.GaussianBlur(luma, (0, 0), deviation), -amount, 0)
    side = 2 * round(_REACH_RATIO * deviation) + 1
    near = np.ones((side, side), np.uint8)
    overshoot = np.full_like(luma, _MAX_OVERSHOOT_LEVELS)
    darkest = cv2.subtract(cv2.erode(luma, near), overshoot)
    brightest = cv2.add(cv2.dilate(luma, near), overshoot)
    lab[..., 0] = cv2.min(cv2.max(sharp, darkest), brightest)
    return cv2.cvtColor(lab, cv2.COLOR_LAB2RGB)
