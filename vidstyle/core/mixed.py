"""RGB whose channels are still to be mixed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vidstyle.core.kernels import compiled, interleaved


@dataclass(frozen=True)
class Mixed:
    """RGB that is still to be multiplied by a matrix, and clipped to 0..1.

    Not by `cv2.transform`, which rounds the last pixels of an array differently, so that the result would
    depend on the bands.

    Attributes:
        color: N x W x 3 float32.
        matrix: 3 x 4 float32, whose last column is added.
    """

    color: np.ndarray
    matrix: np.ndarray

    def whole(self, out: np.ndarray | None = None) -> np.ndarray:
        """The result, N x W x 3 float32, in `out` if that is given."""
        out = np.empty(self.color.shape, np.float32) if out is None else out
        _mix(interleaved(self.color), self.matrix, interleaved(out))
        return out

    def luma(self, weights: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """The result's luma alone, N x W float32, in `out` if that is given, without an array of RGB."""
        out = np.empty(self.color.shape[:2], np.float32) if out is None else out
        _mix_luma(interleaved(self.color), self.matrix, weights, out)
        return out


@compiled
def _mix(color, matrix, out):  # type: ignore[no-untyped-def]
    rows = _row(matrix, 0), _row(matrix, 1), _row(matrix, 2)
    for row in range(out.shape[0]):
        for x in range(out.shape[1] // 3):
            red, green, blue = color[row, 3 * x], color[row, 3 * x + 1], color[row, 3 * x + 2]
            out[row, 3 * x] = _channel(rows[0], red, green, blue)
            out[row, 3 * x + 1] = _channel(rows[1], red, green, blue)
            out[row, 3 * x + 2] = _channel(rows[2], red, green, blue)


@compiled
def _mix_luma(color, matrix, weights, luma):  # type: ignore[no-untyped-def]
    rows = _row(matrix, 0), _row(matrix, 1), _row(matrix, 2)
    of_red, of_green, of_blue = weights[0], weights[1], weights[2]
    for row in range(luma.shape[0]):
        for x in range(luma.shape[1]):
            red, green, blue = color[row, 3 * x], color[row, 3 * x + 1], color[row, 3 * x + 2]
            level = of_red * _channel(rows[0], red, green, blue)
            level += of_green * _channel(rows[1], red, green, blue)
            luma[row, x] = level + of_blue * _channel(rows[2], red, green, blue)


@compiled
def _row(matrix, row):  # type: ignore[no-untyped-def]
    """Its numbers, which a loop over pixels need not read again."""
    return matrix[row, 0], matrix[row, 1], matrix[row, 2], matrix[row, 3]


@compiled
def _channel(row, red, green, blue):  # type: ignore[no-untyped-def]
    value = row[0] * red + row[1] * green + row[2] * blue + row[3]
    return min(max(value, np.float32(0)), np.float32(1))
