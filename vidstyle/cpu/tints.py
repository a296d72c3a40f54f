"""Chroma of inks on paper, from the coverage of the paper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vidstyle.core.codes import Chroma
from vidstyle.core.kernels import compiled

Tint = tuple[float, ...]
"""Blue and red difference of one colour."""


@dataclass(frozen=True)
class Tints:
    """Chroma as a sum: planes, each multiplied by a tint, and a constant tint.

    Attributes:
        planes: N x W float32, any number of them.
        tints: one per plane.
        everywhere: the tint that is added.
    """

    planes: tuple[np.ndarray, ...]
    tints: tuple[Tint, ...]
    everywhere: Tint

    def inked(self, ink: Tint, lines: np.ndarray) -> Tints:
        """Add ink of this tint where the lines, N x W, are dark."""
        planes = *(plane * lines for plane in self.planes), lines
        left = tuple(under - over for under, over in zip(self.everywhere, ink, strict=True))
        return Tints(planes, (*self.tints, left), ink)

    @property
    def mix(self) -> np.ndarray:
        """Weights of the sums for `store_chroma`."""
        return np.array((*self.tints, self.everywhere), np.float32)

    def chroma(self) -> Chroma:
        """Return blue and red difference as planes."""
        blue, red = np.empty((2, *self.planes[0].shape), np.float32)
        for out, everywhere, *parts in zip((blue, red), self.everywhere, *self.tints, strict=True):
            out.fill(everywhere)
            for plane, part in zip(self.planes, parts, strict=True):
                _add(plane, np.float32(part), out)
        return blue, red


@compiled
def _add(plane, part, out):  # type: ignore[no-untyped-def]
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            out[row, x] += plane[row, x] * part
