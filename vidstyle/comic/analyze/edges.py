"""Edges of a picture: their slopes under two Gaussians, whose ratio tells their width."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

FINE_DEVIATION_PX, COARSE_DEVIATION_PX = 0.7, 2.5
"""Standard deviations of the two Gaussians under which edges are compared."""
_STRONG_EDGE_SHARE = 0.03
"""Share of pixels, those with the strongest edges, on which sharpness is measured."""
_SAMPLE_STEP = 13
"""Distance of the slopes that give an estimate of the lowest strong one; no divisor of usual widths."""
_CELL_SIDE_PX = 10
"""Side of a cell whose steepest edge is kept."""


def measure_slopes(luma: np.ndarray, deviation: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the slopes of a picture, H x W uint8, across and down, in levels per two pixels.

    `deviation`: standard deviation, in pixels, of the Gaussian under which they are measured.
    """
    smooth = cv2.GaussianBlur(luma.astype(np.float32), (0, 0), deviation)
    slopes = cv2.Sobel(smooth, -1, 1, 0, ksize=1), cv2.Sobel(smooth, -1, 0, 1, ksize=1)
    return np.abs(slopes[0], out=slopes[0]), np.abs(slopes[1], out=slopes[1])


def steepest_per_cell(slopes: np.ndarray) -> np.ndarray:
    """Return the steepest slope in each cell of a picture, rows x columns uint8, in half levels."""
    side = _CELL_SIDE_PX
    rows, columns = (length // side for length in slopes.shape)
    # Four times as fast as the maximum over the axes of reshaped slopes.
    levels = cv2.convertScaleAbs(slopes, alpha=2)
    steepest = cv2.dilate(levels, np.ones((side, side), np.uint8), anchor=(0, 0))
    return np.ascontiguousarray(steepest[: rows * side : side, : columns * side : side])


def edge_width_sharpness(
    fine: Sequence[np.ndarray], coarse: Sequence[np.ndarray], share: float = _STRONG_EDGE_SHARE
) -> float:
    """Return the sharpness by the width of the strongest edges, a share of all places, 0..1.

    The slope of an edge under a narrow Gaussian, divided by its slope under a wide one, gives its width
    independent of its height. A pan blurs the edges of one direction only, so the wider direction counts.
    """
    number = max(1, round(share * fine[0].size))
    heights, widths = [], []
    for thin, wide in ((np.ravel(each) for each in pair) for pair in zip(fine, coarse, strict=True)):
        strongest = _find_largest(wide, number)
        heights.append(float(wide[strongest].mean()))
        widths.append(float(thin[strongest].mean()) / max(heights[-1], 1e-6))
    # If all edges have one direction, the other direction contains only noise.
    counted = [width for width, height in zip(widths, heights, strict=True) if height > 0.3 * max(heights)]
    best = COARSE_DEVIATION_PX / FINE_DEVIATION_PX
    return float(np.clip((min(counted, default=0) - 1) / (best - 1), 0, 1))


def _find_largest(values: np.ndarray, number: int) -> np.ndarray:
    """Return the indices, in their order, of the largest of flat values, and of all that equal the least.

    A lower limit by a sample excludes most of them, as a partition of all takes four times as long.
    """
    sample = values[::_SAMPLE_STEP]
    count = min(len(sample), 2 * number * len(sample) // len(values) + 1)
    likely = np.flatnonzero(values >= np.partition(sample, -count)[-count])
    if len(likely) < number:
        likely = np.arange(len(values))
    found = values[likely]
    return likely[found >= np.partition(found, -number)[-number]]
