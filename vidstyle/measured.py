"""What measured blocks remember: numbers of the whole picture that follow changes smoothly."""

from __future__ import annotations

import math

import numpy as np

SAMPLES = 320
"""A small copy has at most this many pixels on a side."""


def sampled(plane: np.ndarray) -> np.ndarray:
    """A small copy of a plane: every n-th pixel across and down, from the middle of each n x n square.

    Single pixels, not means, so that the percentiles of the copy are those of the picture.
    """
    stride = -(-max(plane.shape[:2]) // SAMPLES)
    first = [min((stride - 1) // 2, (side - 1) // 2) for side in plane.shape[:2]]
    return plane[first[0] :: stride, first[1] :: stride]


class Settling:
    """Numbers that approach each new measure with a time constant: p += (1 - e^(-dt/tau)) (measure - p)."""

    def __init__(self) -> None:
        self._numbers: np.ndarray | None = None
        self._time = 0.0

    def restart(self) -> None:
        """Take the next measure as it is."""
        self._numbers = None

    def follow(self, measure: np.ndarray, time: float | None, constant: float) -> np.ndarray:
        """The numbers at this time.

        Args:
            measure: what has just been measured.
            time: presentation time in seconds; None for a picture that stands alone.
            constant: seconds; 0 follows at once.
        """
        if self._numbers is None or time is None or constant == 0 or time < self._time:
            self._numbers = measure
        else:
            share = 1 - math.exp(-(time - self._time) / constant)
            self._numbers = self._numbers + share * (measure - self._numbers)
        self._time = time or 0.0
        return self._numbers
