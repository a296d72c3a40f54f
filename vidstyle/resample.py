"""Another size for a plane."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.kernels import compiled

METHODS = {
    "nearest": cv2.INTER_NEAREST,
    "bilinear": cv2.INTER_LINEAR,
    "bicubic": cv2.INTER_CUBIC,
    "lanczos": cv2.INTER_LANCZOS4,
    "area": cv2.INTER_AREA,
}
"""The resampling methods by name, as OpenCV calls them. All but `area` look at a few samples only, so they
alias when shrinking."""


def resample(plane: np.ndarray, shape: tuple[int, int], method: str) -> np.ndarray:
    """The H x W or H x W x 3 plane at another height and width; itself where they are its own.

    Corners stay corners: pixel areas are mapped, not pixel centres.
    """
    if plane.shape[:2] == shape:
        return plane
    if method == "nearest":
        rows, columns = (_nearest(old, new) for old, new in zip(plane.shape, shape, strict=False))
        return np.ascontiguousarray(plane[rows][:, columns])
    if method == "area" and (shape[0] > plane.shape[0] or shape[1] > plane.shape[1]):
        return _grown_by_area(plane, shape)
    return cv2.resize(np.ascontiguousarray(plane), (shape[1], shape[0]), interpolation=METHODS[method])


def _nearest(old: int, new: int) -> np.ndarray:
    """The old pixel under the middle of each new one; an edge belongs to the pixel behind it.

    Not OpenCV's, whose choice at an edge depends on the rounding of its steps.
    """
    return (2 * np.arange(new) + 1) * old // (2 * new)


def _grown_by_area(plane: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Each pixel is an old one, or a mixture of two where it lies across their common edge.

    Not OpenCV's, which takes another old pixel where the rounding of its steps falls short of an edge.
    """
    rows, columns = (_across_edges(old, new) for old, new in zip(plane.shape, shape, strict=False))
    out = np.empty((*shape, *plane.shape[2:]), np.float32)
    channels = plane[0, 0].size
    _mix(plane.reshape(*plane.shape[:2], channels), *rows, *columns, out.reshape(*shape, channels))
    return out


def _across_edges(old: int, new: int) -> tuple[np.ndarray, np.ndarray]:
    """For each new pixel the first of two old ones, and the weight of the second."""
    first = np.arange(new) * old // new
    beyond = np.arange(1, new + 1) * old - (first + 1) * new
    return first, (np.maximum(beyond, 0) / old).astype(np.float32)


@compiled
def _mix(plane, rows, row_weights, columns, column_weights, out):  # type: ignore[no-untyped-def]
    for y in range(out.shape[0]):
        above, down = rows[y], row_weights[y]
        below = min(above + 1, plane.shape[0] - 1)
        for x in range(out.shape[1]):
            left, across = columns[x], column_weights[x]
            right = min(left + 1, plane.shape[1] - 1)
            for channel in range(out.shape[2]):
                upper = plane[above, left, channel]
                upper += across * (plane[above, right, channel] - upper)
                lower = plane[below, left, channel]
                lower += across * (plane[below, right, channel] - lower)
                out[y, x, channel] = upper + down * (lower - upper)
