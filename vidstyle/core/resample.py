"""Resampling of planes."""

from __future__ import annotations

import cv2
import numpy as np

METHODS = {
    "nearest": cv2.INTER_NEAREST,
    "bilinear": cv2.INTER_LINEAR,
    "bicubic": cv2.INTER_CUBIC,
    "lanczos": cv2.INTER_LANCZOS4,
    "area": cv2.INTER_AREA,
}
"""The resampling methods and OpenCV's names of them. All but `area` alias when shrinking; `area` is bicubic
when enlarging."""


OVERSHOOTING = ("bicubic", "lanczos")
"""The methods whose result may leave the range of the plane, beside edges."""


def resample(
    plane: np.ndarray, shape: tuple[int, int], method: str, limits: tuple[float, float] | None = None
) -> np.ndarray:
    """The H x W or H x W x 3 plane at another height and width; itself where they are its own.

    Maps pixel areas, not pixel centres, so that corners stay corners.

    Args:
        limits: the range that the result is clipped to.
    """
    if plane.shape[:2] == shape:
        return plane
    if method == "nearest":
        rows, columns = (_nearest(old, new) for old, new in zip(plane.shape, shape, strict=False))
        return np.ascontiguousarray(plane[rows][:, columns])
    interpolation = METHODS[fitting_method(method, (plane.shape[0], plane.shape[1]), shape)]
    resized = cv2.resize(np.ascontiguousarray(plane), (shape[1], shape[0]), interpolation=interpolation)
    return np.clip(resized, *limits, out=resized) if limits else resized


def scaled_shape(shape: tuple[int, int], factor: float) -> tuple[int, int]:
    """The height and width of a picture that is scaled: rounded, halves up, and never below one pixel.

    >>> scaled_shape((45, 1), 0.5)
    (23, 1)
    """
    height, width = (max(1, int(side * factor + 0.5)) for side in shape)
    return height, width


def fitting_method(method: str, old: tuple[int, int], new: tuple[int, int]) -> str:
    """The method itself, except for `area` when enlarging, which becomes bicubic.

    >>> fitting_method("area", (10, 10), (20, 20))
    'bicubic'
    """
    grows = new[0] > old[0] or new[1] > old[1]
    return "bicubic" if method == "area" and grows else method


def _nearest(old: int, new: int) -> np.ndarray:
    """The old pixel under the centre of each new one; an edge belongs to the pixel after it.

    Not OpenCV's, whose choice at an edge depends on rounding.
    """
    return (2 * np.arange(new) + 1) * old // (2 * new)
