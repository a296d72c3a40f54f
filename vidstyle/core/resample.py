"""Resampling of planes."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vidstyle.core.kernels import interleaved
from vidstyle.core.kernels.weighing import Columns, Taps, weigh_rows_and_columns

METHODS = ("nearest", "bilinear", "bicubic", "lanczos", "area", "smooth")
"""The resampling methods.

All but `area` and `smooth` alias when shrinking; `area` is bicubic when enlarging. `smooth` weighs by the
cubics of Mitchell and Netravali 1988: by a stretched one with B = 0 and C = 1/2 (Catmull and Rom) when
shrinking, by one with B = 1 and C = 0, the B-spline, when enlarging, which is softer than the picture was."""


OVERSHOOTING = ("bicubic", "lanczos", "smooth")
"""The methods whose result may exceed the range of the plane near edges."""

_RADII = {"bilinear": 1, "bicubic": 2, "lanczos": 4, "smooth": 2}
"""How far away the farthest samples are that an interpolation reads."""


@dataclass(frozen=True)
class Resampling:
    """From one height and width to another, a band of rows at a time.

    Maps pixel areas, not pixel centres, so that corners stay corners.

    Attributes:
        old, new: height and width.
        method: one of METHODS; of those that `fitting_method` returns.
        border: pixels on every side of the new plane that lie beyond the picture; if negative, of the old
            one. Only for interpolation. The picture's border is repeated at the size of the old plane: a
            reduced plane that is extended afterwards would repeat a mean of the pixels near the border.
    """

    old: tuple[int, int]
    new: tuple[int, int]
    method: str
    border: int = 0

    def rows_read(self, top: int, bottom: int) -> tuple[int, int]:
        """Return the old rows that the new rows top..bottom read: the first, and the one after the last."""
        return _rows_read(self, top, bottom)

    def rows(
        self, plane: np.ndarray, first: int, top: int, bottom: int, out: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the new rows top..bottom, float32, equal in any band; nearest samples keep their type.

        Args:
            plane: N x W or N x W x 3, the old rows from `first` on: at least the rows of `rows_read`.
            out: where they are written, but for the method "nearest"; None for a new array.
        """
        taps = _taps(self.method, self.old[0], self.new[0], self.border)
        places, weights = (each[top:bottom] for each in taps)
        if self.method == "nearest":
            columns_read, _ = _taps(self.method, self.old[1], self.new[1], 0)
            return np.ascontiguousarray(plane[places - first][:, columns_read])
        if out is None:
            out = np.empty((bottom - top, self.new[1], *plane.shape[2:]), np.float32)
        columns = _columns(self.method, self.old[1], self.new[1], self.border, plane[0, 0].size)
        grows = self.new[0] - 2 * max(self.border, 0) > self.old[0] + 2 * min(self.border, 0)
        weigh_rows_and_columns(
            interleaved(plane), (places - first, weights), columns, interleaved(out), grows
        )
        return out


def resample(plane: np.ndarray, shape: tuple[int, int], method: str, border: int = 0) -> np.ndarray:
    """Return the H x W or H x W x 3 plane at another size, float32; itself if it has this size.

    `border` is as in `Resampling`.
    """
    old = plane.shape[0], plane.shape[1]
    if old == shape and not border:
        return plane
    return Resampling(old, shape, fitting_method(method, old, shape), border).rows(plane, 0, 0, shape[0])


def scaled_shape(shape: tuple[int, int], factor: float) -> tuple[int, int]:
    """Return the height and width of a picture that is scaled: rounded, halves up, and never below one pixel.

    >>> scaled_shape((45, 1), 0.5)
    (23, 1)
    """
    height, width = (max(1, int(side * factor + 0.5)) for side in shape)
    return height, width


def fitting_method(method: str, old: tuple[int, int], new: tuple[int, int]) -> str:
    """Return the method itself, except for `area` when enlarging, which becomes bicubic.

    >>> fitting_method("area", (10, 10), (20, 20))
    'bicubic'
    """
    grows = new[0] > old[0] or new[1] > old[1]
    return "bicubic" if method == "area" and grows else method


@lru_cache(maxsize=512)
def _rows_read(resampling: Resampling, top: int, bottom: int) -> tuple[int, int]:
    """See `Resampling.rows_read`; all frames of a film read the same rows in each band."""
    old = resampling.old[0]
    first, weights = _taps(resampling.method, old, resampling.new[0], resampling.border)
    end = int(first[bottom - 1]) + weights.shape[1]
    start = min(max(int(first[top]), 0), old - 1)
    return start, max(min(end, old), start + 1)


@lru_cache(maxsize=64)
def _columns(method: str, old: int, new: int, border: int, channels: int) -> Columns:
    return Columns.of(_taps(method, old, new, border), old, channels)


@lru_cache(maxsize=64)
def _taps(method: str, old: int, new: int, border: int) -> Taps:
    """Return the old samples that each new one reads."""
    if method == "nearest":
        # Not OpenCV's, whose choice at an edge depends on rounding: an edge belongs to the pixel after it.
        return (2 * np.arange(new) + 1) * old // (2 * new), np.ones((new, 1), np.float32)
    first, weights = _shares(old, new) if method == "area" else _interpolation(method, old, new, border)
    return first, weights.astype(np.float32)


def _shares(old: int, new: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the first of the old pixels under each new one, and how much of it each of them takes."""
    edges = np.arange(new + 1) * old / new
    first = np.floor(edges[:-1] + 1e-9).astype(np.int64)
    index = first[:, None] + np.arange(math.ceil(old / new) + 1)
    parts = np.minimum(index + 1, edges[1:, None]) - np.maximum(index, edges[:-1, None])
    weights = np.maximum(parts, 0) * new / old
    return first, weights if weights[:, -1].max() > 1e-9 else weights[:, :-1]


def _interpolation(method: str, old: int, new: int, border: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the first old pixel that an interpolation reads for each new one, and all weights."""
    outside, places = max(border, 0), np.arange(new)
    old, new, inside = old + 2 * min(border, 0), new - 2 * outside, max(-border, 0)
    stretch = max(old / new, 1.0) if method == "smooth" else 1.0
    half = math.ceil(_RADII[method] * stretch)
    moved = (2 * (places - outside) + 1) * old + new
    first = moved // (2 * new) - half
    x = abs(first[:, None] + np.arange(1, 2 * half + 1) - moved[:, None] / (2 * new)) / stretch
    if method == "bilinear":
        weights = 1 - x
    elif method == "lanczos":
        weights = np.sinc(x) * np.sinc(x / _RADII[method])
    else:
        near, far = _bicubic(x) if method == "bicubic" else _smooth(x, old >= new)
        weights = np.where(x < 1, near, np.where(x < 2, far, 0))
    return first + inside, weights / weights.sum(axis=1, keepdims=True)


def _bicubic(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Weights at distances below and above 1: OpenCV's, whose slope at 1 is -0.75."""
    return (1.25 * x - 2.25) * x * x + 1, ((-0.75 * x + 3.75) * x - 6) * x + 3


def _smooth(x: np.ndarray, shrinks: bool) -> tuple[np.ndarray, np.ndarray]:
    """Weights at distances below and above 1 for `smooth`."""
    if shrinks:
        return (1.5 * x - 2.5) * x * x + 1, ((-0.5 * x + 2.5) * x - 4) * x + 2
    return (0.5 * x - 1) * x * x + 2 / 3, (2 - x) ** 3 / 6
