"""Drift: how far the marks of a style have moved with the objects of a film from their places on the page.

A drift is a picture of vectors on a coarse grid over the page, h x w x 2 float32: to the right, relative to
the page's width, and down, relative to its height. None where no mark has moved.
"""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled, index_at
from vidstyle.core.white_noise import lattice_noise, white_noise


def drifted_noise(
    drift: np.ndarray | None,
    rows: tuple[int, int],
    columns: tuple[int, int],
    pitch: float,
    page: tuple[int, int],
    count: int,
    drawing: int = 0,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the random numbers of the marks that the squares of a grid over the page show, one each.

    A mark keeps its numbers while it moves from square to square. As each square shows one mark, marks are
    never crowded: where motion stretches or covers the picture, marks end and others begin.

    Args:
        rows, columns: of the squares, from the first number up to, but not including, the second.
        pitch: side of a square in pixels.
        page: height and width of the page in the same pixels.
        count: numbers of a mark.
        drawing: added to the row of the lattice that the numbers are taken from.

    Returns:
        rows x columns x count float32, 0..1; and the distance of each mark from its own place in the square,
        in squares, -0.5..0.5, to the right and down: rows x columns x 2 float32.
    """
    shape = rows[1] - rows[0], columns[1] - columns[0]
    if drift is None:
        places = np.arange(*rows) + drawing, np.arange(count * columns[0], count * columns[1])
        return white_noise(*places).reshape(*shape, count), np.zeros((*shape, 2), np.float32)
    numbers, shifts = np.empty((*shape, count), np.float32), np.empty((*shape, 2), np.float32)
    size = np.float32(pitch), np.float32(page[0]), np.float32(page[1])
    _find_marks(drift, (rows[0], columns[0]), size, drawing, numbers, shifts)
    return numbers, shifts


@compiled
def _drift_at(drift, right, down):  # type: ignore[no-untyped-def]
    """Return the drift at a place, both relative to the page's width and height; not interpolated."""
    row = index_at(np.floor(down * np.float32(drift.shape[0])), drift.shape[0] - 1)
    column = index_at(np.floor(right * np.float32(drift.shape[1])), drift.shape[1] - 1)
    return drift[row, column, 0], drift[row, column, 1]


@compiled
def _find_marks(drift, first, size, drawing, numbers, shifts):  # type: ignore[no-untyped-def]
    (pitch, height, width), half = size, np.float32(0.5)
    for i in range(numbers.shape[0]):
        row = i + first[0]
        down = (np.float32(row) + half) * pitch / height
        for j in range(numbers.shape[1]):
            column = j + first[1]
            right = (np.float32(column) + half) * pitch / width
            across, along = _drift_at(drift, right, down)
            across, along = across * width / pitch, along * height / pitch
            passed, sunk = np.floor(across + half), np.floor(along + half)
            shifts[i, j, 0], shifts[i, j, 1] = across - passed, along - sunk
            own_row, own = row - np.int32(sunk) + drawing, (column - np.int32(passed)) * numbers.shape[2]
            for number in range(numbers.shape[2]):
                numbers[i, j, number] = lattice_noise(own_row, own + number)
