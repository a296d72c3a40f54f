"""Chroma of inks on paper, which follows from what covers the paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vidstyle.core.planes import Chroma

Tint = tuple[float, ...]
"""Blue and red difference of one colour."""


@dataclass(frozen=True)
class Tints:
    """Chroma as a sum: planes, each with a tint by which it is multiplied, and the same tint everywhere.

    Averages of chroma are the same sums of averages of the planes, of which there may be one instead of two.

    Attributes:
        planes: N x W float32, any number of them.
        tints: one for each.
        everywhere: the tint that is added.
    """

    planes: tuple[np.ndarray, ...]
    tints: tuple[Tint, ...]
    everywhere: Tint

    def inked(self, ink: Tint, lines: np.ndarray) -> Tints:
        """With ink of this tint where the lines, N x W, are dark."""
        planes = *(plane * lines for plane in self.planes), lines
        left = tuple(under - over for under, over in zip(self.everywhere, ink, strict=True))
        return Tints(planes, (*self.tints, left), ink)

    def chroma(self, planes: Sequence[np.ndarray]) -> Chroma:
        """Blue and red difference, of `planes` or of averages of them."""
        blue, red = (np.full(planes[0].shape, level, np.float32) for level in self.everywhere)
        for plane, (by_blue, by_red) in zip(planes, self.tints, strict=True):
            blue += plane * np.float32(by_blue)
            red += plane * np.float32(by_red)
        return blue, red
