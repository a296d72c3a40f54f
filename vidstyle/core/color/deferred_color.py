"""RGB whose last step is deferred to its readers, so that the result needs no array."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vidstyle.core.kernels import compiled, interleaved

RGB = tuple[float, float, float]

NO_LAYERS = np.empty((0, 0), np.float32), np.empty(0, np.float32)
"""Replaces `Printed.layers` if there is no ink and no paper."""


@dataclass(frozen=True)
class Printed:
    """RGB that is still to be multiplied by the paper's colour, and then covered with ink.

    Attributes:
        color: N x W x 3 float32.
        paper: what RGB is multiplied by, and then clipped to 0..1; None where that has been done.
        lines: N x W float32, the part of each pixel that the ink leaves; None without ink.
    """

    color: np.ndarray
    paper: RGB | None = None
    lines: np.ndarray | None = None
    ink: RGB = (0.0, 0.0, 0.0)

    def inked(self, ink: RGB, lines: np.ndarray) -> Printed:
        """With ink of this colour where the lines, N x W, are dark."""
        return replace(self, lines=lines, ink=ink)

    @property
    def layers(self) -> tuple[np.ndarray, np.ndarray]:
        """What `lay_on` takes: lines, one row or all, and paper, limits and ink."""
        lines = np.ones((1, self.color.shape[1]), np.float32) if self.lines is None else self.lines
        low, high = (-np.inf, np.inf) if self.paper is None else (0, 1)
        return lines, np.array([*(self.paper or (1, 1, 1)), low, high, *self.ink], np.float32)

    def whole(self, out: np.ndarray | None = None) -> np.ndarray:
        """Return the result, N x W x 3 float32, in `out` if that is given."""
        out = np.empty(self.color.shape, np.float32) if out is None else out
        _lay_on_rows(interleaved(self.color), *self.layers, interleaved(out))
        return out


@compiled
def _lay_on_rows(color, lines, tones, out):  # type: ignore[no-untyped-def]
    for row in range(out.shape[0]):
        lay_on(color[row], lines[min(row, lines.shape[0] - 1)], tones, out[row])


@compiled(noalias=True)
def lay_on(color, lines, tones, out):  # type: ignore[no-untyped-def]
    """One row of `Printed`; `tones` are paper, limits and ink of its layers."""
    low, high = tones[3], tones[4]
    for x in range(lines.size):
        for channel in range(3):
            ink = tones[5 + channel]
            under = min(max(color[3 * x + channel] * tones[channel], low), high)
            out[3 * x + channel] = (under - ink) * lines[x] + ink


@dataclass(frozen=True)
class Mixed:
    """RGB that is still to be multiplied by a matrix, and clipped to 0..1.

    White highlights of HDR, above 1, are clipped to their smallest channel, and stay highlights.

    Not by `cv2.transform`, which rounds the last pixels of an array differently, so that the result would
    depend on the bands.

    Attributes:
        color: N x W x 3 float32.
        matrix: 3 x 4 float32, whose last column is added.
    """

    color: np.ndarray
    matrix: np.ndarray

    def whole(self, out: np.ndarray | None = None) -> np.ndarray:
        """Return the result, N x W x 3 float32, in `out` if that is given."""
        out = np.empty(self.color.shape, np.float32) if out is None else out
        _mix(interleaved(self.color), self.matrix, interleaved(out))
        return out

    def luma(self, weights: np.ndarray, out: np.ndarray | None = None) -> np.ndarray:
        """Return only luma, N x W float32, in `out` if that is given, without an array of RGB."""
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
    return min(max(value, np.float32(0)), max(min(red, green, blue), np.float32(1)))
