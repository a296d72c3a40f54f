"""Pixelate: large square pixels."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated

import numpy as np

from vidstyle.block import PageRegion, ResultRows, Slider, block
from vidstyle.core.kernels import compiled, interleaved, look_up_at


def whole_side(size: float | np.float32) -> int:
    """A length in pixels rounded as a GPU has it, halves up."""
    return int(np.float32(size) + np.float32(0.5))


@block("filter", on="channels", radius=lambda size: whole_side(size) - 1)
def pixelate(
    picture: np.ndarray,
    place: PageRegion,
    out: ResultRows,
    size: Annotated[float, Slider(1, 64, "side of a pixel, rounded to whole ones", "px", (3, 12))] = 6,
) -> np.ndarray:
    """Fill squares, which are fixed to the page, with their mean colour."""
    side, rows = whole_side(size), interleaved(picture)
    channels = rows.shape[1] // picture.shape[1]
    cells = cells_across(picture.shape[1], side, channels)
    scratch = rows_for(cells[1].size, side, channels)
    _fill(rows, (place.top, *place.margin), (side, channels), *cells, *scratch, interleaved(out))
    return out


@lru_cache(maxsize=64)
def cells_across(width: int, side: int, channels: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How the numbers of a row belong to cells of the page.

    Returns:
        int32, of each number of a row its number in a row of means; int32, of each mean the first number of a
        row that it is of; float32, of each mean how many they are.
    """
    numbers = np.arange(width * channels)
    owners = numbers // channels // side * channels + numbers % channels
    means = np.arange(owners[-1] + 1)
    starts = means // channels * side * channels + means % channels
    return owners.astype(np.int32), starts.astype(np.int32), np.bincount(owners).astype(np.float32)


def rows_for(means: int, side: int, channels: int) -> tuple[np.ndarray, np.ndarray]:
    """Scratch for `average_cells`: a row of whole cells, with zeros at its end, and a row of means."""
    return np.zeros(means * side + channels, np.float32), np.empty(means, np.float32)


@compiled(noalias=True)
def average_cells(rows, step, starts, counts, line, means):  # type: ignore[no-untyped-def]
    """The means of cells of these rows.

    Args:
        step: numbers along a cell, and to the next one of a channel.
        starts, counts: from `cells_across`.
        line, means: from `rows_for`; the means are written.
    """
    side, channels = step
    for x in range(rows.shape[1]):
        line[x] = rows[0, x]
    for row in range(1, rows.shape[0]):
        for x in range(rows.shape[1]):
            line[x] += rows[row, x]
    for i in range(means.size):
        means[i] = 0
    for column in range(side):
        part = line[column * channels :]
        for i in range(means.size):
            means[i] += part[look_up_at(starts[i])]
    for i in range(means.size):
        means[i] /= np.float32(rows.shape[0]) * counts[i]


@compiled(noalias=True)
def _fill(picture, place, step, owners, starts, counts, line, means, out):  # type: ignore[no-untyped-def]
    """Each cell with its mean; rows of the same cells are copies.

    Args:
        place: the row of the page that is the first, and how many are a margin above and below.
    """
    top, above, below = place
    first, last = 0, picture.shape[0] - below
    while first < last:
        end = min(first + step[0] - (top + first) % step[0], picture.shape[0])
        begin = max(first, above)
        if begin < end:
            average_cells(picture[first:end], step, starts, counts, line, means)
            filled = out[begin - above]
            for x in range(filled.size):
                filled[x] = means[look_up_at(owners[x])]
            for row in range(begin + 1, min(end, last)):
                for x in range(filled.size):
                    out[row - above, x] = filled[x]
        first = end
