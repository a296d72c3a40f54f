"""Shade of faces as ink can show it: in few steps, and in squares that are full or empty."""

from __future__ import annotations

import numpy as np

from vidstyle.regions.boxes import Rectangle
from vidstyle.regions.rasters import cell_means

SHADE_STEP_COUNT, STEP_RANGE = 4, (0.25, 0.75)
"""Steps of shade from paper to ink, and the part of each in which it changes: soft edges without stairs."""
BAYER_WEIGHTS = np.array([[0, 2], [3, 1]])
"""Order in which four squares of a page are filled, the more of them the darker the shade."""


def in_steps(shade: np.ndarray) -> np.ndarray:
    """Return shade, 0..1, in few steps with soft edges."""
    level = np.clip(shade, 0, 1) * np.float32(SHADE_STEP_COUNT)
    whole, (low, high) = np.floor(level), STEP_RANGE
    part = np.clip((level - whole - np.float32(low)) / np.float32(high - low), 0, 1)
    return np.asarray((whole + part) / np.float32(SHADE_STEP_COUNT), np.float32)


def in_squares(plane: np.ndarray, window: Rectangle, square: tuple[int, int]) -> np.ndarray:
    """Return coverage in which the squares of a page are full or empty.

    Bayer 1973, "An Optimum Method for Two-Level Rendition of Continuous-Tone Pictures".

    Args:
        plane: coverage in a window of the page, H x W float32, 0..1.
        window: the window.
        square: height and width of a square.
    """
    (down, across), (height, width) = square, BAYER_WEIGHTS.shape
    rows, columns = np.arange(window.top, window.bottom), np.arange(window.left, window.right)
    order = BAYER_WEIGHTS[np.ix_(rows // down % height, columns // across % width)]
    limits = (order + np.float32(0.5)) / BAYER_WEIGHTS.size
    return np.asarray(cell_means(plane, window, square) > limits, np.float32)
