"""Soft masks of faces and of colours."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.core.planes import chroma_rows, luma_rows
from vidstyle.regions.boxes import Box

HEAD_RADIUS_RATIOS = 0.7, 0.8
"""Radii of the ellipse on which `head_mask` is 0.5, relative to a face's width and height: with hair."""
FACE_RADIUS_RATIOS = 0.56, 0.66
"""Radii of the ellipse on which `face_mask` is 0.5: within the contour of most heads."""
EDGE_WIDTH_RATIO = 0.15
"""Width of the soft edge inside and outside these ellipses, relative to their radius."""
INNER_EDGE_RATIO = 0.45
"""Width of the edge of `inner_mask`, relative to that radius."""
RAISED_RATIO = 0.05
"""Distance of the centre of a mask above the centre of the face, relative to the face's height."""
LUMA_WEIGHT = 0.25
"""Weight of a difference of luma, relative to one of chroma, in `color_mask`: a screen is lit unevenly."""


def mask_box(face: Box[float]) -> Box[float]:
    """Return the box outside of which `face_mask` is 0."""
    return _ellipse_box(face, 1 + EDGE_WIDTH_RATIO)


def inner_box(face: Box[float]) -> Box[float]:
    """Return the box outside of which `inner_mask` is 0."""
    return _ellipse_box(face, 1.0)


def face_mask(face: Box[float], window: Box[int]) -> np.ndarray:
    """Return the mask of a face in a region of the picture: an ellipse with a soft edge.

    Returns:
        H x W float32, 1 in the face and 0 outside of `mask_box`.
    """
    return _soft_ellipse(_distance(face, window, FACE_RADIUS_RATIOS))


def head_mask(face: Box[float], window: Box[int]) -> np.ndarray:
    """Return the mask of a face with hair and chin, as `face_mask`."""
    return _soft_ellipse(_distance(face, window, HEAD_RADIUS_RATIOS))


def inner_mask(face: Box[float], window: Box[int]) -> np.ndarray:
    """Return a mask that is 1 in the middle of a face, and 0 where `face_mask` is 0.5, H x W float32."""
    return _smoothstep((1 - _distance(face, window, FACE_RADIUS_RATIOS)) / INNER_EDGE_RATIO)


def _ellipse_box(face: Box[float], scale: float) -> Box[float]:
    across, down = _center(face)
    wide, high = scale * FACE_RADIUS_RATIOS[0] * face.width, scale * FACE_RADIUS_RATIOS[1] * face.height
    return Box(across - wide, down - high, across + wide, down + high)


def _soft_ellipse(distance: np.ndarray) -> np.ndarray:
    return _smoothstep((1 + EDGE_WIDTH_RATIO - distance) / (2 * EDGE_WIDTH_RATIO))


def _smoothstep(ramp: np.ndarray) -> np.ndarray:
    ramp = np.clip(ramp, 0, 1)
    return np.asarray(ramp * ramp * (3 - 2 * ramp), np.float32)


def _center(face: Box[float]) -> tuple[float, float]:
    across, down = face.center
    return across, down - RAISED_RATIO * face.height


def _distance(face: Box[float], window: Box[int], radii: tuple[float, float]) -> np.ndarray:
    """Return the distance from the centre of a mask, relative to the ellipse with these radii."""
    across, down = _center(face)
    wide, high = radii[0] * face.width, radii[1] * face.height
    columns = (np.arange(window.left, window.right, dtype=np.float32) + np.float32(0.5 - across)) / wide
    rows = (np.arange(window.top, window.bottom, dtype=np.float32) + np.float32(0.5 - down)) / high
    return cv2.sqrt(rows[:, None] ** 2 + columns**2)


def color_mask(
    picture: Picture, color: tuple[float, float, float], tolerance: float, softness: float
) -> np.ndarray:
    """Return the mask of a colour, H x W float32, 0..1.

    Args:
        picture: any picture.
        color: RGB, 0..1.
        tolerance: distance in chroma up to which a pixel is inside, 0..1.
        softness: width of the soft edge beyond it, 0..1.
    """
    rows = 0, picture.shape[0]
    luma, blue, red = picture.encoding.yuv_from_color(color)
    planes = (
        (luma_rows(picture, *rows) - np.float32(luma)) * np.float32(LUMA_WEIGHT),
        *chroma_rows(picture, *rows),
    )
    distance = np.square(planes[0])
    for plane, center in zip(planes[1:], (blue, red), strict=True):
        distance += np.square(plane - np.float32(center))
    ramp = (np.float32(tolerance + softness) - cv2.sqrt(distance)) / np.float32(max(softness, 1e-6))
    return np.clip(ramp, 0, 1)
