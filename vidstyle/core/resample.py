"""Resampling of planes."""

from __future__ import annotations

import math
from concurrent.futures import Executor
from functools import lru_cache

import cv2
import numpy as np

from vidstyle.core.bands import CallingThread, in_bands
from vidstyle.core.kernels import interleaved
from vidstyle.core.planes import weigh_rows_and_columns

METHODS = {
    "nearest": cv2.INTER_NEAREST,
    "bilinear": cv2.INTER_LINEAR,
    "bicubic": cv2.INTER_CUBIC,
    "lanczos": cv2.INTER_LANCZOS4,
    "area": cv2.INTER_AREA,
    "smooth": -1,
}
"""The resampling methods and OpenCV's numbers of them, which has no `smooth`.

All but `area` and `smooth` alias when shrinking; `area` is bicubic when enlarging. `smooth` weighs by the
cubics of Mitchell and Netravali 1988: by a stretched one with B = 0 and C = 1/2 (Catmull and Rom) when
shrinking, by one with B = 1 and C = 0, the B-spline, when enlarging, which is softer than the picture was."""


OVERSHOOTING = ("bicubic", "lanczos", "smooth")
"""The methods whose result may leave the range of the plane, beside edges."""


def resample(
    plane: np.ndarray,
    shape: tuple[int, int],
    method: str,
    limits: tuple[float, float] | None = None,
    pool: Executor | None = None,
) -> np.ndarray:
    """The H x W or H x W x 3 plane at another height and width; itself where they are its own.

    Maps pixel areas, not pixel centres, so that corners stay corners.

    Args:
        limits: the range that the result is clipped to.
        pool: threads for what OpenCV does not do on its own.
    """
    if plane.shape[:2] == shape:
        return plane
    if method == "nearest":
        rows, columns = (_nearest(old, new) for old, new in zip(plane.shape, shape, strict=False))
        return np.ascontiguousarray(plane[rows][:, columns])
    fitting = fitting_method(method, (plane.shape[0], plane.shape[1]), shape)
    # Of areas that are no whole number of pixels OpenCV's means take thrice as long.
    if fitting == "smooth" or (
        fitting == "area" and (plane.shape[0] % shape[0] or plane.shape[1] % shape[1])
    ):
        resized = _weighed(plane, shape, fitting, pool or CallingThread())
    else:
        interpolation = METHODS[fitting]
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


def _weighed(plane: np.ndarray, shape: tuple[int, int], method: str, pool: Executor) -> np.ndarray:
    """Each new pixel a weighted sum of old ones, for `area` and `smooth`."""
    (index, weights), columns = (
        _taps(method, plane.shape[0], shape[0], 1),
        _taps(method, plane.shape[1], shape[1], plane[0, 0].size),
    )
    out = np.empty((*shape, *plane.shape[2:]), np.float32)
    flat = interleaved(plane), out.reshape(shape[0], -1)

    def run(top: int, bottom: int) -> None:
        rows = index[top:bottom], weights[top:bottom]
        weigh_rows_and_columns(flat[0], rows, columns, flat[1][top:bottom], shape[0] > plane.shape[0])

    in_bands(pool, shape, 0, run)
    return out


@lru_cache(maxsize=32)
def _taps(method: str, old: int, new: int, channels: int) -> tuple[np.ndarray, np.ndarray]:
    """For each new number the old ones, channels apart, that it is made of, and their weights."""
    index, weights = _shares(old, new) if method == "area" else _cubic_weights(old, new)
    index = channels * np.clip(index, 0, old - 1)[:, None] + np.arange(channels)[:, None]
    return index.reshape(new * channels, -1), np.repeat(weights, channels, axis=0).astype(np.float32)


def _shares(old: int, new: int) -> tuple[np.ndarray, np.ndarray]:
    """The old pixels under each new one, and how much of it each of them takes."""
    edges = np.arange(new + 1) * old / new
    first = np.floor(edges[:-1] + 1e-9).astype(np.int64)
    index = first[:, None] + np.arange(math.ceil(old / new) + 1)
    parts = np.minimum(index + 1, edges[1:, None]) - np.maximum(index, edges[:-1, None])
    weights = np.maximum(parts, 0) * new / old
    return (index, weights) if weights[:, -1].max() > 1e-9 else (index[:, :-1], weights[:, :-1])


def _cubic_weights(old: int, new: int) -> tuple[np.ndarray, np.ndarray]:
    """The old pixels around each new one that `smooth` reads, and their weights."""
    stretch = max(old / new, 1.0)
    half = math.ceil(2 * stretch)
    moved = ((2 * np.arange(new) + 1) * old + new)[:, None]
    index = moved // (2 * new) - half + np.arange(2 * half)
    x = abs(index + 1 - moved / (2 * new)) / stretch
    if old >= new:
        near, far = (1.5 * x - 2.5) * x * x + 1, ((-0.5 * x + 2.5) * x - 4) * x + 2
    else:
        near, far = (0.5 * x - 1) * x * x + 2 / 3, (2 - x) ** 3 / 6
    weights = np.where(x < 1, near, np.where(x < 2, far, 0))
    return index, weights / weights.sum(axis=1, keepdims=True)


def _nearest(old: int, new: int) -> np.ndarray:
    """The old pixel under the centre of each new one; an edge belongs to the pixel after it.

    Not OpenCV's, whose choice at an edge depends on rounding.
    """
    return (2 * np.arange(new) + 1) * old // (2 * new)
