"""Soft masks of faces."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.regions.boxes import Box

RADIUS_RATIOS = 0.7, 0.8
"""Radii of the ellipse on which a mask is 0.5, relative to width and height of a face: with hair and chin."""
EDGE_WIDTH_RATIO = 0.15
"""Width of the soft edge inside and outside that ellipse, relative to its radius."""
INNER_EDGE_RATIO = 0.45
"""Width of the edge of `inner_mask`, relative to that radius."""
RAISED_RATIO = 0.05
"""Distance of the centre of a mask above the centre of the face, relative to the face's height."""


def mask_box(face: Box[float]) -> Box[float]:
    """Return the box outside of which the mask of a face is 0."""
    across, down = face.center
    wide, high = (
        ratio * (1 + EDGE_WIDTH_RATIO) * side
        for ratio, side in zip(RADIUS_RATIOS, (face.width, face.height), strict=True)
    )
    middle = down - RAISED_RATIO * face.height
    return Box(across - wide, middle - high, across + wide, middle + high)


def face_mask(face: Box[float], window: Box[int]) -> np.ndarray:
    """Return the mask of a face in a region of the picture: an ellipse with a soft edge.

    Returns:
        H x W float32, 1 in the face and 0 outside of `mask_box`.
    """
    ramp = np.clip((1 + EDGE_WIDTH_RATIO - _distance(face, window)) / (2 * EDGE_WIDTH_RATIO), 0, 1)
    return np.asarray(ramp * ramp * (3 - 2 * ramp), np.float32)


def inner_mask(face: Box[float], window: Box[int]) -> np.ndarray:
    """Return a mask that is 1 in the middle of a face, and 0 where `face_mask` is 0.5, H x W float32."""
    ramp = np.clip((1 - _distance(face, window)) / INNER_EDGE_RATIO, 0, 1)
    return np.asarray(ramp * ramp * (3 - 2 * ramp), np.float32)


def _distance(face: Box[float], window: Box[int]) -> np.ndarray:
    """Return the distance from the centre of a mask, relative to the ellipse on which it is 0.5."""
    box = mask_box(face)
    across, down = box.center
    wide, high = (side / 2 / (1 + EDGE_WIDTH_RATIO) for side in (box.width, box.height))
    columns = (np.arange(window.left, window.right, dtype=np.float32) + np.float32(0.5 - across)) / wide
    rows = (np.arange(window.top, window.bottom, dtype=np.float32) + np.float32(0.5 - down)) / high
    return cv2.sqrt(rows[:, None] ** 2 + columns**2)
