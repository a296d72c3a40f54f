"""Colours of three interleaved channels, as kernels take them."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels.declare import compiled


def mix_channels(color: np.ndarray, matrix: np.ndarray, out: np.ndarray) -> np.ndarray:
    """Multiply RGB, N x W x 3, by a matrix, 3 x 4, whose last column is added; in `out`, clipped to 0..1.

    Not `cv2.transform`, which rounds the last pixels of an array differently, so that the result would depend
    on the bands.
    """
    _mix_channels(interleaved(color), matrix, interleaved(out))
    return out


def gray_rgb(luma: np.ndarray) -> np.ndarray:
    """RGB whose three channels are one plane, N x W: a view, N x W x 3, that is only read."""
    return np.broadcast_to(luma[:, :, None], (*luma.shape, 3))


def is_gray(color: np.ndarray) -> bool:
    """Whether RGB, N x W x 3, is a view of one plane."""
    return color.ndim == 3 and color.strides[2] == 0


def interleaved(color: np.ndarray) -> np.ndarray:
    """RGB, N x W x 3, as rows of 3 W numbers for kernels: a view where it is contiguous.

    There, channels lie three numbers apart. Of an array of three dimensions the compiler does not know that,
    and makes no vectors.
    """
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


@compiled
def _mix_channels(color, matrix, out):  # type: ignore[no-untyped-def]
    zero, one = np.float32(0), np.float32(1)
    a, b, c, d = matrix[0, 0], matrix[0, 1], matrix[0, 2], matrix[0, 3]
    e, f, g, h = matrix[1, 0], matrix[1, 1], matrix[1, 2], matrix[1, 3]
    i, j, k, m = matrix[2, 0], matrix[2, 1], matrix[2, 2], matrix[2, 3]
    for row in range(out.shape[0]):
        for x in range(out.shape[1] // 3):
            red, green, blue = color[row, 3 * x], color[row, 3 * x + 1], color[row, 3 * x + 2]
            out[row, 3 * x] = min(max(a * red + b * green + c * blue + d, zero), one)
            out[row, 3 * x + 1] = min(max(e * red + f * green + g * blue + h, zero), one)
            out[row, 3 * x + 2] = min(max(i * red + j * green + k * blue + m, zero), one)
