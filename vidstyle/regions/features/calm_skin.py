"""Removes grain from a face by a bilateral filter, and features by morphological opening and closing."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.sampling import sampled_quantile

FEATURE_RATIO, HIGHLIGHT_RATIO = 0.2, 0.07
"""Diameters of the discs that fill features such as an eye with its brow, and bright parts such as teeth,
relative to the face's height."""
SOFTNESS_RATIO = 0.03
"""Standard deviation of the Gaussian that smooths skin without features, relative to the face's height."""
LAPLACIAN_WEIGHTS, GRAIN_FACTOR = np.array([[1, -2, 1], [-2, 4, -2], [1, -2, 1]], np.float32), 6 * 0.6745
"""Laplacian of luma, and the median of its size for noise with a standard deviation of 1."""
MIN_GRAIN_LUMA, GRAIN_CONTRAST_RATIO, GRAIN_RADIUS_PX = 0.004, 4.0, 1.5
"""Grain from which luma is smoothed; contrast that counts as grain, relative to it; and standard deviation of
the Gaussian that smooths. Tuned on faces of 50 to 130 lines in six photographs."""
MAX_SEARCHED_HEIGHT_PX = 96
"""Larger faces are searched for skin in a reduced copy."""


def without_grain(luma: np.ndarray) -> np.ndarray:
    """Return luma of a face without noise, stubble and blocks of compression, H x W float32.

    Immerkær 1996, "Fast Noise Variance Estimation", with a median in place of the mean.
    """
    luma = np.asarray(luma, np.float32)
    sizes = np.abs(cv2.filter2D(luma, -1, LAPLACIAN_WEIGHTS))
    grain = sampled_quantile(sizes, 0.5, default=0.0) / GRAIN_FACTOR
    if grain < MIN_GRAIN_LUMA:
        return luma
    return cv2.bilateralFilter(luma, 5, GRAIN_CONTRAST_RATIO * grain, GRAIN_RADIUS_PX)


def skin_luma(luma: np.ndarray, height: float) -> np.ndarray:
    """Return luma without features; `height`: of the face."""
    factor = max(1.0, height / MAX_SEARCHED_HEIGHT_PX)
    size = tuple(max(1, round(side / factor)) for side in luma.shape[::-1])
    small = luma if factor == 1 else cv2.resize(luma, size, interpolation=cv2.INTER_AREA)
    height /= factor
    calm = cv2.morphologyEx(small, cv2.MORPH_OPEN, _disc(HIGHLIGHT_RATIO * height))
    skin = cv2.morphologyEx(calm, cv2.MORPH_CLOSE, _disc(FEATURE_RATIO * height))
    skin = cv2.GaussianBlur(skin, (0, 0), max(0.5, SOFTNESS_RATIO * height))
    return skin if factor == 1 else cv2.resize(skin, luma.shape[::-1], interpolation=cv2.INTER_LINEAR)


def _disc(size: float) -> np.ndarray:
    """Return a disc for morphology, of at least three pixels."""
    side = max(3, 2 * int(size / 2) + 1)
    return cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
