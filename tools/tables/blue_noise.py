"""Make the blue-noise tile that ships with `dither`: `python -m tools.tables.blue_noise`.

Void and cluster: Ulichney 1993, "The void-and-cluster method for dither array generation".
"""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.blocks.dither import shipped_thresholds

TILE_SIDE_PX = 128
CLUSTER_DEVIATION = 1.5
"""Standard deviation in pixels of the Gaussian that measures density; Ulichney's choice."""
INITIAL_POINTS_RATIO = 1 / 10
"""Share of the pixels in the initial random pattern, which is then spread out."""


class PointSet:
    """Points on a periodic tile, with their density at each pixel."""

    def __init__(self) -> None:
        away = np.minimum(np.arange(TILE_SIDE_PX), TILE_SIDE_PX - np.arange(TILE_SIDE_PX)) ** 2
        self._near = np.exp(-(away[:, None] + away[None]) / (2 * CLUSTER_DEVIATION * CLUSTER_DEVIATION))
        self._crowd = np.zeros((TILE_SIDE_PX, TILE_SIDE_PX))
        self.set = np.zeros((TILE_SIDE_PX, TILE_SIDE_PX), bool)

    def toggle(self, pixel: int) -> int:
        """Set a pixel, or clear it if it is set, and return it."""
        row, column = divmod(pixel, TILE_SIDE_PX)
        self.set[row, column] ^= True
        sign = 1 if self.set[row, column] else -1
        self._crowd += sign * np.roll(self._near, (row, column), (0, 1))
        return pixel

    def tightest_cluster(self) -> int:
        """Return the set pixel with the highest density."""
        return int(np.where(self.set, self._crowd, -np.inf).argmax())

    def largest_void(self) -> int:
        """Return the empty pixel with the lowest density."""
        return int(np.where(self.set, np.inf, self._crowd).argmin())


def rank_pixels() -> np.ndarray:
    """Return the order in which pixels are set from dark to bright, TILE_SIDE_PX x TILE_SIDE_PX int."""
    points, count = PointSet(), int(TILE_SIDE_PX * TILE_SIDE_PX * INITIAL_POINTS_RATIO)
    for pixel in np.random.default_rng(1).choice(TILE_SIDE_PX * TILE_SIDE_PX, count, replace=False):
        points.toggle(int(pixel))
    while points.toggle(points.tightest_cluster()) != (pixel := points.largest_void()):
        points.toggle(pixel)
    points.toggle(pixel)
    start, found = np.flatnonzero(points.set), np.empty(TILE_SIDE_PX * TILE_SIDE_PX, int)
    for rank in range(count - 1, -1, -1):
        found[points.toggle(points.tightest_cluster())] = rank
    for pixel in start:
        points.toggle(int(pixel))
    for rank in range(count, TILE_SIDE_PX * TILE_SIDE_PX):
        found[points.toggle(points.largest_void())] = rank
    return found.reshape(TILE_SIDE_PX, TILE_SIDE_PX)


if __name__ == "__main__":
    cv2.imwrite(
        str(shipped_thresholds()["blue"]),
        (rank_pixels() * 256 // (TILE_SIDE_PX * TILE_SIDE_PX)).astype(np.uint8),
    )
