"""The tone of the skin of a face, and copies of its parts in a fixed size."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.regions.boxes import Box


def measure_skin(luma: np.ndarray, face: Box, top_ratio: float) -> float:
    """Return the median luma of a face, 1..255; 0 if it is outside the picture.

    Args:
        luma: a picture, H x W uint8.
        face: the box of the face, in pixels of the picture.
        top_ratio: the part of the face at its top that does not count.
    """
    height, width = luma.shape
    left, top = max(0, round(face.left)), max(0, round(face.top + top_ratio * face.height))
    skin = luma[top : min(height, round(face.bottom)), left : min(width, round(face.right))]
    return max(1.0, float(np.median(skin))) if skin.size else 0.0


def copy_part(luma: np.ndarray, place: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Return a copy of a part of a picture, H x W uint8.

    Args:
        luma: the picture, H x W uint8.
        place: affine map from the copy to the picture, 2 x 3.
        size: width and height of the copy.
    """
    return cv2.warpAffine(
        *(luma, place, size),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )
