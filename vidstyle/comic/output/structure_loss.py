"""How much of the large forms of a picture a drawing loses, and how much contrast it invents."""

from __future__ import annotations

from itertools import product

import cv2
import numpy as np

_COARSE_SIDE_PX, _BLUR_DEVIATION_PX = 160, 1.5
"""Longer side of the copies that are compared, and standard deviation of the Gaussian that removes marks."""
_MAX_GREY_CHROMA = 3.0
"""Mean absolute chroma component (CIELAB) of a drawing up to which only lightness is compared."""
_DISTANCES_PX = 6, 14
"""Distances of the points of these copies whose colours are compared."""
_MIN_DIFFERENCE, _MAX_DIFFERENCE = 5.0, 20.0
"""Colour difference (CIE 1976) from which two points of the source show two things, and the largest weight
of such a pair: black next to white survives any style."""
_KEPT_RATIO = 0.8
"""Difference in the drawing, relative to the source, from which it is kept."""
_MAX_GAIN_FACTOR, _MAX_GAIN_DIFFERENCE, _MAX_INVENTED_DIFFERENCE = 2.5, 8.0, 20.0
"""Difference in the drawing that is not invented: a factor on the difference in the source, and what a style
adds; and the largest invented difference that counts."""
_INVENTED_WEIGHT = 0.3
"""Weight of the mean invented difference."""


def measure_structure_loss(source: np.ndarray, drawn: np.ndarray) -> float:
    """Return how badly a drawing keeps the large forms of its source: 0 if all of them stay, 1 if none does.

    Invented contrast increases it; of a drawing without colours, only lightness counts. Values of one style
    can be compared; line drawings have larger ones.

    Args:
        source: the picture, H x W x 3 uint8.
        drawn: the picture in its style, of the same aspect.
    """
    before, after = _coarse_lab(source), _coarse_lab(drawn)
    if np.abs(after[..., 1:]).mean() < _MAX_GREY_CHROMA:
        before, after = before[..., :1], after[..., :1]
    lost = weights = invented = pairs = 0.0
    for distance, axis in product(_DISTANCES_PX, (0, 1)):
        one, other = _differences(before, distance, axis), _differences(after, distance, axis)
        size, drawn_size = (np.linalg.norm(each, axis=2) for each in (one, other))
        weight = np.where(size > _MIN_DIFFERENCE, np.minimum(size, _MAX_DIFFERENCE), 0)
        kept = (one * other).sum(axis=2) / np.maximum(_KEPT_RATIO * size * size, 1e-6)
        lost += float((weight * (1 - np.clip(kept, 0, 1))).sum())
        weights += float(weight.sum())
        gain = drawn_size - _MAX_GAIN_FACTOR * size - _MAX_GAIN_DIFFERENCE
        invented += float(np.clip(gain, 0, _MAX_INVENTED_DIFFERENCE).sum())
        pairs += size.size
    return lost / max(weights, 1.0) + _INVENTED_WEIGHT * invented / max(pairs, 1.0)


def _coarse_lab(color: np.ndarray) -> np.ndarray:
    """Return a small, smooth copy, H x W x 3 float32 CIELAB."""
    factor = _COARSE_SIDE_PX / max(color.shape)
    size = tuple(max(1, round(side * factor)) for side in color.shape[1::-1])
    small = cv2.resize(color, size, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    return cv2.GaussianBlur(cv2.cvtColor(small, cv2.COLOR_RGB2LAB), (0, 0), _BLUR_DEVIATION_PX)


def _differences(lab: np.ndarray, distance: int, axis: int) -> np.ndarray:
    """Return the differences of points at a distance along an axis."""
    lines = np.moveaxis(lab, axis, 0)
    return lines[distance:] - lines[:-distance]
