"""Things that stand out from what is around them: a ball, a title, somebody far away."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from vidstyle.comic.moment import Box

_SIDE = 128
_SCALES = (1.5, 3.0, 6.0)
"""Deviations of the Gaussians under which things are seen; their surroundings are twice as wide."""
_OUT = 18.0
"""A thing differs so much from its surroundings: of lightness and chroma together, of 255 each."""
_LEAST, _MOST = 0.0015, 0.12
"""The part of the picture that a thing covers: less may be a light or a leaf, more is a ground."""


_NEAR = 0.02
"""Things are one if no more of the picture's longer side lies between them: the letters of a word."""


def blobs(color: np.ndarray) -> list[Box]:
    """Boxes about the things in a picture, H x W x 3 uint8, in its pixels; they do not meet."""
    gap, apart = _NEAR * max(color.shape), list[Box]()
    for thing in _parts(color):
        while near := next((each for each in apart if _is_near(each, thing, gap)), None):
            apart.remove(near)
            thing = thing.union(near)
        apart.append(thing)
    return apart


def find_blobs(color: np.ndarray) -> np.ndarray:
    """How much each place of a picture, H x W x 3 uint8, differs from what is around it: H x W, 0..1."""
    lab = _small_lab(color)
    most = np.max([_standing_out(lab, scale) for scale in _SCALES[1:]], axis=0)
    return cv2.resize(np.minimum(1, most / (2 * _OUT)), (color.shape[1], color.shape[0]))


def _small_lab(color: np.ndarray) -> np.ndarray:
    """A small copy, float32."""
    height, width = color.shape[:2]
    factor = min(1.0, _SIDE / max(height, width))
    size = max(1, round(width * factor)), max(1, round(height * factor))
    small = cv2.resize(color, size, interpolation=cv2.INTER_AREA)
    return cv2.cvtColor(small, cv2.COLOR_RGB2LAB).astype(np.float32)


def _is_near(one: Box, other: Box, gap: float) -> bool:
    across = max(one.left, other.left) - min(one.right, other.right)
    return max(across, max(one.top, other.top) - min(one.bottom, other.bottom)) <= gap


def _parts(color: np.ndarray) -> Iterator[Box]:
    height, width = color.shape[:2]
    small = _small_lab(color)
    size = small.shape[1], small.shape[0]
    for scale in _SCALES:
        out = _standing_out(small, scale) > _OUT
        _, _, found, _ = cv2.connectedComponentsWithStats(out.astype(np.uint8), connectivity=8)
        for left, top, wide, high, area in found[1:]:
            if _LEAST < area / out.size and wide * high < _MOST * out.size:
                # What stands out is less than the thing by the width of its soft edge.
                x, y = width / size[0], height / size[1]
                yield Box(
                    max(0.0, (left - scale) * x),
                    max(0.0, (top - scale) * y),
                    min(float(width), (left + wide + scale) * x),
                    min(float(height), (top + high + scale) * y),
                )


def _standing_out(lab: np.ndarray, scale: float) -> np.ndarray:
    """How much each place differs from its surroundings: H x W float32."""
    near, around = (
        cv2.GaussianBlur(lab, (0, 0), deviation, borderType=cv2.BORDER_REPLICATE)
        for deviation in (scale, 2 * scale)
    )
    return np.asarray(np.linalg.norm(near - around, axis=2), np.float32)
