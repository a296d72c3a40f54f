"""How well a drawn panel can be read: its detail, black areas and main face."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from vidstyle.comic.analyze.faces.face_search import cut_face
from vidstyle.comic.analyze.sharpness import FULL_FACE_DETAIL_LEVELS, measure_detail
from vidstyle.regions.boxes import Box

FaceScore = Callable[[np.ndarray, Box], float | None]
"""Returns how much a part of a picture, H x W x 3 uint8, looks like a face, 0..1; None if it is not known."""

# The limits were tuned on 66 panels of 17 pages, of which judges or we could not read 19.
_FULL_DETAIL_LEVELS = 32.0
"""Slope, of 255 per pixel, in the sharpest part of a picture from which it has enough detail."""
_BLACK_LEVEL, _MAX_FREE_BLACK_SHARE = 50, 0.25
"""Luma below which ink is black, and the share of a panel that may be black."""
_FACE_BLACK_WEIGHT = 0.5
"""How much more black counts if a face is seen: it may stand out from the dark."""
_FACE_DEVIATION_RATIO, _MIN_FACE_DEVIATION_PX = 1 / 60, 0.5
"""Standard deviation of the Gaussian that removes dots, in heights of the face, and its minimum."""
_MIN_FACE_SCORE, _MIN_FACE_SCORE_RATIO = 0.2, 0.35
"""A face is lost if it scores less than the first value, and less than this fraction of its source."""
_MIN_DARK_FACE_SCORE, _MAX_FACE_BLACK_SHARE = 0.4, 0.42
"""A face is also lost below this score if more of it is black."""
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
    weight = 1.0 if face is None else _FACE_BLACK_WEIGHT
    found *= 1 - weight * max(0.0, black - _MAX_FREE_BLACK_SHARE)
    if face is not None:
        found *= min(1.0, measure_detail(cut_face(source, face)) / FULL_FACE_DETAIL_LEVELS)
        found *= _LOST_FACE_FACTOR if _is_face_lost(source, drawn, face, face_score) else 1.0
    return found


def _is_face_lost(source: np.ndarray, drawn: np.ndarray, face: Box, face_score: FaceScore) -> bool:
    """Whether a face of the source is not a face in the drawing."""
    deviation = max(_MIN_FACE_DEVIATION_PX, _FACE_DEVIATION_RATIO * face.height)
    before, after = face_score(source, face), face_score(cv2.GaussianBlur(drawn, (0, 0), deviation), face)
    if before is None or after is None:
        return False
    black = float(np.mean(cv2.cvtColor(cut_face(drawn, face), cv2.COLOR_RGB2GRAY) < _BLACK_LEVEL))
    is_dark = black > _MAX_FACE_BLACK_SHARE and after < _MIN_DARK_FACE_SCORE
    return is_dark or after < min(_MIN_FACE_SCORE, _MIN_FACE_SCORE_RATIO * before)
