"""Another size for a plane."""

from __future__ import annotations

import cv2
import numpy as np

METHODS = {
    "nearest": cv2.INTER_NEAREST_EXACT,
    "bilinear": cv2.INTER_LINEAR,
    "bicubic": cv2.INTER_CUBIC,
    "lanczos": cv2.INTER_LANCZOS4,
    "area": cv2.INTER_AREA,
}
"""The resampling methods by name. All but `area` look at a few samples only, so they alias when shrinking."""


def resample(plane: np.ndarray, shape: tuple[int, int], method: str) -> np.ndarray:
    """The H x W or H x W x 3 plane at another height and width; itself where they are its own.

    Corners stay corners: pixel areas are mapped, not pixel centres.
    """
    if plane.shape[:2] == shape:
        return plane
    return cv2.resize(np.ascontiguousarray(plane), (shape[1], shape[0]), interpolation=METHODS[method])
