"""A mask of the pixels that have nearly one colour, such as a green screen."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.core.planes import chroma_rows, luma_rows

LUMA_WEIGHT = 0.25
"""Weight of a difference of luma, relative to one of chroma: a screen is lit unevenly."""


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
