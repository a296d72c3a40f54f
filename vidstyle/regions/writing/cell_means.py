"""Means of the measures of strokes in cells of a picture, and around each cell."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.regions.writing.morphology import average_floats
from vidstyle.regions.writing.stroke_measures import LEVEL_COUNT, PRODUCT_COUNT, StrokeMeasures

CELL_PX = 4
"""Pixels of the copy, across and down, with one weight."""

MEAN_COUNT = LEVEL_COUNT + PRODUCT_COUNT
"""Means in each cell: of all measures, in their order."""
STROKES, BRIGHT, EVEN, PEAKS, ISLANDS, SQUARES, OTHERS, MIXED = range(MEAN_COUNT)


def average_measures(
    measures: StrokeMeasures, shape: tuple[int, int], near: int, sums: tuple[np.ndarray, np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the means of measures in cells, the means of these around each cell, and directions of slopes.

    The directions are interleaved, as OpenCV rounds square roots in different ways in turn.

    Args:
        shape: number of cells.
        near: side of the square around each cell, odd.
        sums: see `average_floats`.
    """
    means, nearby = np.empty((2, 2, MEAN_COUNT, *shape), np.float32)
    is_quarter = measures.levels.shape[2:] == (2 * shape[0], 2 * shape[1])
    if not is_quarter:
        for side, own in enumerate(means):
            for plane, out in zip((*measures.levels[side], *measures.products[side]), own, strict=True):
                out[:] = cv2.resize(plane, shape[::-1], interpolation=cv2.INTER_AREA)
    slopes = np.empty((2, *shape, 2), np.float32)
    _average(*measures, is_quarter, near, sums, (means, nearby), slopes)
    return means, nearby, slopes


@compiled
def _average(levels, products, is_quarter, near, sums, fields, slopes):  # type: ignore[no-untyped-def]
    """Compute means in cells, if each is 2 x 2 pixels; then means around each, and directions of slopes."""
    means, nearby = fields
    for side in range(2):
        for kind in range(MEAN_COUNT):
            out = means[side, kind]
            if is_quarter and kind < LEVEL_COUNT:
                _average_cells(_round_up, levels[side, kind], out)
            elif is_quarter:
                _average_cells(_round_even, products[side, kind - LEVEL_COUNT], out)
            average_floats(out, near, sums, nearby[side, kind])
        own = nearby[side]
        _find_directions(own[SQUARES], own[OTHERS], own[MIXED], slopes[0, ..., side], slopes[1, ..., side])


@compiled
def _average_cells(rounded, pixels, out):  # type: ignore[no-untyped-def]
    """Compute the means of 2 x 2 pixels; `rounded` returns a quarter of their sum."""
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            row, column = 2 * y, 2 * x
            total = np.int32(pixels[row, column]) + np.int32(pixels[row, column + 1])
            total += np.int32(pixels[row + 1, column]) + np.int32(pixels[row + 1, column + 1])
            out[y, x] = rounded(total)


@compiled
def _round_up(total):  # type: ignore[no-untyped-def]
    """As OpenCV does for numbers of 8 bits."""
    return np.int32(total + 2) >> 2


@compiled
def _round_even(total):  # type: ignore[no-untyped-def]
    """As OpenCV does for numbers of 16 bits: to the even number between two."""
    return np.int32(total + 1 + ((total >> 2) & 1)) >> 2


@compiled
def _find_directions(squares, others, mixed, across, down):  # type: ignore[no-untyped-def]
    for y in range(across.shape[0]):
        for x in range(across.shape[1]):
            across[y, x] = squares[y, x] - others[y, x]
            down[y, x] = np.float32(2) * mixed[y, x]
