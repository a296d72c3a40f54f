"""Pixelate: large square pixels."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import PageRegion, Slider, block
from vidstyle.core.kernels import compiled, interleaved


def whole_side(size: float | np.float32) -> int:
    """A length in pixels rounded as a GPU has it, halves up."""
    return int(np.float32(size) + np.float32(0.5))


@block("filter", on="channels", radius=lambda size: whole_side(size) - 1)
def pixelate(
    picture: np.ndarray,
    place: PageRegion,
    size: Annotated[float, Slider(1, 64, "side of a pixel, rounded to whole ones", "px", (3, 12))] = 6,
) -> np.ndarray:
    """Fill squares, which are fixed to the page, with their mean colour."""
    side = whole_side(size)
    rows, columns = cells_of(picture, place, side, side)
    out = np.empty(picture.shape, np.float32)
    _fill(interleaved(cell_means(picture, rows, columns)), rows, columns, interleaved(out))
    return out


def cells_of(
    picture: np.ndarray, place: PageRegion, height: int, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """The number of each row's and of each column's cell of the page, from that of the first row on."""
    rows = np.arange(place.top, place.top + picture.shape[0]) // height
    return rows - rows[0], np.arange(picture.shape[1]) // width


def cell_means(picture: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """The mean over each cell, as far as the picture goes: one pixel for each."""
    channels = picture.shape[2:]
    means = np.empty((rows[-1] + 1, columns[-1] + 1, *channels), np.float32)
    line = np.empty(picture.size // len(picture), np.float32)
    _average(interleaved(picture), rows, columns, line, interleaved(means))
    return means


@compiled
def _average(picture, rows, columns, line, means):  # type: ignore[no-untyped-def]
    """Sum up the rows of a cell, then its columns."""
    channels = line.size // columns.size
    first = 0
    for cell in range(means.shape[0]):
        count = 0
        line[:] = 0
        while first + count < rows.size and rows[first + count] == cell:
            for x in range(line.size):
                line[x] += picture[first + count, x]
            count += 1
        first += count
        for channel in range(channels):
            begin = 0
            for column in range(means.shape[1] // channels):
                total, end = np.float32(0), begin
                while end < columns.size and columns[end] == column:
                    total += line[channels * end + channel]
                    end += 1
                means[cell, channels * column + channel] = total / np.float32(count * (end - begin))
                begin = end


@compiled
def _fill(means, rows, columns, out):  # type: ignore[no-untyped-def]
    """Each cell with its mean; rows of the same cells are copies."""
    channels = out.shape[1] // columns.size
    for row in range(out.shape[0]):
        if row > 0 and rows[row] == rows[row - 1]:
            for x in range(out.shape[1]):
                out[row, x] = out[row - 1, x]
            continue
        for x in range(columns.size):
            for channel in range(channels):
                out[row, channels * x + channel] = means[rows[row], channels * columns[x] + channel]
