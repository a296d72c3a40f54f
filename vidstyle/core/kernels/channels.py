"""Colours of three interleaved channels, as kernels take them."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels.declare import compiled


def gray_rgb(luma: np.ndarray) -> np.ndarray:
    """RGB whose three channels are one plane, N x W: a view, N x W x 3, that is only read."""
    return np.broadcast_to(luma[:, :, None], (*luma.shape, 3))


def is_gray(color: np.ndarray) -> bool:
    """Return whether RGB, N x W x 3, is a view of one plane."""
    return color.ndim == 3 and color.strides[2] == 0


def interleaved(color: np.ndarray) -> np.ndarray:
    """RGB, N x W x 3, as rows of 3 W numbers for kernels: a view where it is contiguous.

    There, channels lie three numbers apart. Of an array of three dimensions the compiler does not know that,
    and makes no vectors.
    """
    if color.ndim == 2 and color.flags.c_contiguous:
        return color
    if is_gray(color):
        rows = np.empty((len(color), 3 * color.shape[1]), np.float32)
        _repeat_rows(np.ascontiguousarray(color[:, :, 0]), rows)
        return rows
    return np.ascontiguousarray(color).reshape(len(color), -1)


def gray_or_interleaved(color: np.ndarray) -> np.ndarray:
    """Rows as of `interleaved`, but the plane itself, rows of W numbers, of RGB that is gray."""
    return np.ascontiguousarray(color[:, :, 0]) if is_gray(color) else interleaved(color)


@compiled
def clipped_sum(one, other):  # type: ignore[no-untyped-def]
    """The sum of two numbers, at least 0 and at most 1."""
    return min(max(one + other, np.float32(0)), np.float32(1))


@compiled
def _repeat_rows(luma, color):  # type: ignore[no-untyped-def]
    for row in range(luma.shape[0]):
        repeat_row(luma[row], color[row])


@compiled(noalias=True)
def repeat_row(luma, color):  # type: ignore[no-untyped-def]
    """A row of gray RGB, of luma."""
    for x in range(luma.size):
        level = luma[x]
        color[3 * x], color[3 * x + 1], color[3 * x + 2] = level, level, level
