"""Makes the tile of blue noise that `dither` comes with: `python -m tools.tables.blue_noise`.

Void and cluster: Ulichney 1993, "The void-and-cluster method for dither array generation".
"""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.blocks.dither import shipped_thresholds

SIDE = 128
SIGMA = 1.5
"""Of the Gaussian by which points are near one another; Ulichney's choice."""
FIRST = 10
"""One point in so many is set by random, and spread out."""


class Points:
    """Points on a tile that repeats; how crowded each place is follows every change."""

    def __init__(self) -> None:
        away = np.minimum(np.arange(SIDE), SIDE - np.arange(SIDE)) ** 2
        self._near = np.exp(-(away[:, None] + away[None]) / (2 * SIGMA * SIGMA))
        self._crowd = np.zeros((SIDE, SIDE))
        self.set = np.zeros((SIDE, SIDE), bool)

    def turn(self, place: int) -> int:
        """Set a place, or clear it if it is set; returns it."""
        row, column = divmod(place, SIDE)
        self.set[row, column] ^= True
        sign = 1 if self.set[row, column] else -1
        self._crowd += sign * np.roll(self._near, (row, column), (0, 1))
        return place

    def cluster(self) -> int:
        """The set place that is most crowded."""
        return int(np.where(self.set, self._crowd, -np.inf).argmax())

    def void(self) -> int:
        """The free place that is least crowded."""
        return int(np.where(self.set, np.inf, self._crowd).argmin())


def ranks() -> np.ndarray:
    """The order in which places are set as it grows brighter, SIDE x SIDE."""
    points, count = Points(), SIDE * SIDE // FIRST
    for place in np.random.default_rng(1).choice(SIDE * SIDE, count, replace=False):
        points.turn(int(place))
    while points.turn(points.cluster()) != (place := points.void()):
        points.turn(place)
    points.turn(place)
    start, found = np.flatnonzero(points.set), np.empty(SIDE * SIDE, int)
    for rank in range(count - 1, -1, -1):
        found[points.turn(points.cluster())] = rank
    for place in start:
        points.turn(int(place))
    for rank in range(count, SIDE * SIDE):
        found[points.turn(points.void())] = rank
    return found.reshape(SIDE, SIDE)


if __name__ == "__main__":
    cv2.imwrite(str(shipped_thresholds()["blue"]), (ranks() * 256 // (SIDE * SIDE)).astype(np.uint8))
