"""How well a drawn panel can be read: its detail, black areas and main face."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from vidstyle.regions.boxes import Box

FaceScore = Callable[[np.ndarray, Box], float | None]
"""Returns how much a part of a picture, H x W x 3 uint8, looks like a face, 0..1; None if it is not known."""

# The limits were tuned on 66 panels of 17 pages, of which judges or we could not read 19.
_MEASURED_PX = 360
"""Side of a square with the area of the copies that are measured."""
_CELL_COUNT, _PART_CELL_COUNT = 6, 2
"""The picture is divided into this many cells a side; overlapping parts of some cells a side are measured."""
_DETAIL_DEVIATION_PX, _DETAIL_PERCENTILE = 0.7, 98
"""Standard deviation of the Gaussian under which slopes are measured, and their percentile that counts."""
_FULL_DETAIL_LEVELS = 32.0
"""Slope, of 255 per pixel, in the sharpest part of a picture from which it has enough detail."""
_BLACK_LEVEL, _MAX_FREE_BLACK_SHARE = 50, 0.25
"""Luma below which ink is black, and the share of a panel that may be black."""
_FACE_DEVIATION_RATIO, _MIN_FACE_DEVIATION_PX = 1 / 60, 0.5
"""Standard deviation of the Gaussian that removes dots, in heights of the face, and its minimum."""
_MIN_FACE_SCORE, _MIN_FACE_SCORE_RATIO = 0.2, 0.35
"""A face is lost if it scores less than the first value, and less than this fraction of its source."""
_LOST_FACE_FACTOR = 0.6
"""Factor on the readability of a panel whose face is lost."""


def measure_readability(
    source: np.ndarray, drawn: np.ndarray, face: Box | None, face_score: FaceScore
) -> float:
    """Return how well a drawn panel can be read, 0..1.

    Args:
        source: the part of the frame that it shows, H x W x 3 uint8.
        drawn: the panel in its style, of the same size.
        face: of the person that it shows, in its pixels, if it is large; or None.
        face_score: tells faces.
    """
    luma = cv2.cvtColor(drawn, cv2.COLOR_RGB2GRAY)
    black = float(np.mean(luma < _BLACK_LEVEL))
    found = min(1.0, measure_detail(source) / _FULL_DETAIL_LEVELS)
    found *= 1 - max(0.0, black - _MAX_FREE_BLACK_SHARE)
    if face is not None and _is_face_lost(source, drawn, face, face_score):
        found *= _LOST_FACE_FACTOR
    return found


def measure_detail(color: np.ndarray) -> float:
    """Return the slope of the edges in the sharpest part of a picture, H x W x 3 uint8, of 255 per pixel.

    Soft surroundings of something sharp do not count.
    """
    factor = _MEASURED_PX / np.sqrt(color.shape[0] * color.shape[1])
    method = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    size = (max(_CELL_COUNT, round(side * factor)) for side in color.shape[1::-1])
    luma = cv2.cvtColor(cv2.resize(color, tuple(size), interpolation=method), cv2.COLOR_RGB2GRAY)
    smooth = cv2.GaussianBlur(luma.astype(np.float32), (0, 0), _DETAIL_DEVIATION_PX)
    slopes = np.hypot(cv2.Sobel(smooth, -1, 1, 0, ksize=1), cv2.Sobel(smooth, -1, 0, 1, ksize=1)) / 2
    height, width = slopes.shape
    starts = range(_CELL_COUNT - _PART_CELL_COUNT + 1)
    parts = (
        slopes[
            row * height // _CELL_COUNT : (row + _PART_CELL_COUNT) * height // _CELL_COUNT,
            column * width // _CELL_COUNT : (column + _PART_CELL_COUNT) * width // _CELL_COUNT,
        ]
        for row in starts
        for column in starts
    )
    return max(float(np.percentile(part, _DETAIL_PERCENTILE)) for part in parts)


def _is_face_lost(source: np.ndarray, drawn: np.ndarray, face: Box, face_score: FaceScore) -> bool:
    """Whether a face of the source is not a face in the drawing."""
    deviation = max(_MIN_FACE_DEVIATION_PX, _FACE_DEVIATION_RATIO * face.height)
    before, after = face_score(source, face), face_score(cv2.GaussianBlur(drawn, (0, 0), deviation), face)
    if before is None or after is None:
        return False
    return after < min(_MIN_FACE_SCORE, _MIN_FACE_SCORE_RATIO * before)
