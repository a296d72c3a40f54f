"""Pixelate: large square pixels."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated

import numpy as np

from vidstyle.block import PageRegion, Raster, ResultRows, Slider, block
from vidstyle.core.kernels import compiled, interleaved, look_up_at


def whole_side(size: float | np.float32) -> int:
    """Round a length in pixels as on a GPU, halves up."""
    return int(np.float32(size) + np.float32(0.5))


@block(
    "filter",
    on="channels",
    radius=lambda size: whole_side(size) - 1,
    raster=lambda size: Raster.of_cells(whole_side(size), whole_side(size)),
    label="Pixels",
    category="print",
    aliases=(
        "pixel art, 8-bit, blocks, censor, mosaic, tiles, retro, video game, low resolution, "
        "minecraft, gameboy"
    ),
)
def pixelate(
    picture: np.ndarray,
    place: PageRegion,
    out: ResultRows,
    size: Annotated[
        float,
        Slider(
            1,
            64,
            "side of a square, rounded to whole pixels",
            "px",
            (3, 12),
            label="Pixel size",
            max_detail=4,
        ),
    ] = 6,
) -> np.ndarray:
    """Divide the picture into large square pixels.

    Squares get their mean colour, and are fixed to the page.
    """
    side, rows = whole_side(size), interleaved(picture)
    channels = rows.shape[1] // picture.shape[1]
    cells = cells_across(picture.shape[1], side, channels)
    scratch = rows_for(cells[1].size, side, channels)
    _fill(rows, (place.top, *place.margin), (side, channels), *cells, *scratch, interleaved(out))
    return out


@lru_cache(maxsize=64)
def cells_across(width: int, side: int, channels: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Assign the numbers of a row to cells of the page.

    Returns:
        The index of the mean for each number of a row, int32; the index of the first number of each mean,
        int32; the count of numbers of each mean, float32.
    """
    numbers = np.arange(width * channels)
    owners = numbers // channels // side * channels + numbers % channels
    means = np.arange(owners[-1] + 1)
    starts = means // channels * side * channels + means % channels
    return owners.astype(np.int32), starts.astype(np.int32), np.bincount(owners).astype(np.float32)


def rows_for(means: int, side: int, channels: int) -> tuple[np.ndarray, np.ndarray]:
    """Return scratch for `average_cells`: a row of whole cells, padded by zeros, and a row of means."""
    return np.zeros(means * side + channels, np.float32), np.empty(means, np.float32)


@compiled(noalias=True)
def average_cells(rows, step, starts, counts, line, means):  # type: ignore[no-untyped-def]
    """Compute the means of the cells of these rows.

    Args:
        step: count of numbers along a cell, and the distance to the next number of a channel.
        starts, counts: from `cells_across`.
        line, means: from `rows_for`; means is written.
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
    """Fill each cell with its mean; further rows of the same cells are copies.

    Args:
        place: the number of the first row on the page, and the numbers of margin rows above and below.
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
