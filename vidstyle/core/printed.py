"""RGB on coloured paper and under ink."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vidstyle.core.kernels import compiled, interleaved

RGB = tuple[float, float, float]

NO_LAYERS = np.empty((0, 0), np.float32), np.empty(0, np.float32)
"""In place of `Printed.layers` where nothing is to be laid on."""


@dataclass(frozen=True)
class Printed:
    """RGB that is still to be multiplied by the paper's colour, and then covered with ink.

    Who reads it row by row does both on the way, and needs no array of the result.

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

    def whole(self) -> np.ndarray:
        """The result, N x W x 3 float32, new."""
        out = np.empty(self.color.shape, np.float32)
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
