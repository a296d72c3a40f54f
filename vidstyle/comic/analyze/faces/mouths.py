"""How far the mouth of a face is open, by the dark between its lips."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.comic.analyze.faces.face_parts import copy_part, measure_skin
from vidstyle.regions.boxes import Box, Point

_SIZE_PX, _SIZE_RATIOS, _TOP_RATIO = (24, 16), (0.5, 0.34), 0.14
"""Width and height of the copy of a mouth; its size in heights of the face; and how far it reaches above the
middle of the mouth."""
_SMOOTH_RATIO, _SKIN_TOP_RATIO = 1 / 80, 0.3
"""Standard deviation of the Gaussian against noise, in heights of the face; and the part of the face at its
top, forehead and hair, that does not count as skin."""
_MAX_DARK_RATIO, _BLACK_RATIO, _FULL_DARKNESS_SHARE = 0.62, 0.32, 0.02
"""Luma, relative to the skin, below which a place is between lips, and where it counts fully; and mean
darkness of a mouth that speaks.

They were tuned on 50 faces of three films: closed mouths have 0.000 to 0.002, open ones 0.005 to 0.068.
"""
_LIP_WEIGHTS = (
    np.hypot(*np.meshgrid(np.linspace(-1, 1, _SIZE_PX[0]), np.linspace(-0.9, 1.1, _SIZE_PX[1]))) <= 1
)
"""Part of that copy that lips can cover; its corners may show the background, if a face looks aside."""


def measure_open_mouth(luma: np.ndarray, face: Box, mouth: Point) -> float:
    """Return how far a mouth is open, 0..1.

    Args:
        luma: a picture, H x W uint8.
        face: the box of the face, in pixels of the picture.
        mouth: the middle of its mouth.
    """
    skin = measure_skin(luma, face, _SKIN_TOP_RATIO)
    if not skin:
        return 0.0
    (columns, rows), (wide, high) = _SIZE_PX, (ratio * face.height for ratio in _SIZE_RATIOS)
    place = np.array(
        [
            [wide / columns, 0, mouth[0] - wide / 2],
            [0, high / rows, mouth[1] - _TOP_RATIO * face.height],
        ],
        np.float32,
    )
    smooth = cv2.GaussianBlur(luma, (0, 0), max(0.3, _SMOOTH_RATIO * face.height))
    tone = copy_part(smooth, place, _SIZE_PX).astype(np.float32) / skin
    dark = np.clip((_MAX_DARK_RATIO - tone) / (_MAX_DARK_RATIO - _BLACK_RATIO), 0, 1)
    return min(1.0, float(dark[_LIP_WEIGHTS].mean()) / _FULL_DARKNESS_SHARE)
