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


def interleaved(color: np.ndarray) -> np.ndarray:
    """RGB, N x W x 3, as rows of 3 W numbers for kernels: a view where it is contiguous.

    There, channels lie three numbers apart. Of an array of three dimensions the compiler does not know that,
    and makes no vectors.
    """
    return np.ascontiguousarray(color).reshape(len(color), -1)


@compiled
def clipped_sum(one, other):  # type: ignore[no-untyped-def]
    """The sum of two numbers, at least 0 and at most 1."""
    return min(max(one + other, np.float32(0)), np.float32(1))


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
