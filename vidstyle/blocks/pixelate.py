"""Pixelate: large square pixels."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import PageRegion, Slider, block


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
    return cell_means(picture, rows, columns)[rows[:, None], columns]


def cells_of(
    picture: np.ndarray, place: PageRegion, height: int, width: int
) -> tuple[np.ndarray, np.ndarray]:
    """The number of each row's and of each column's cell of the page, from that of the first row on."""
    rows = np.arange(place.top, place.top + picture.shape[0]) // height
    return rows - rows[0], np.arange(picture.shape[1]) // width


def cell_means(picture: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """The mean over each cell, as far as the picture goes: one pixel for each."""
    starts = [np.flatnonzero(np.diff(cells, prepend=-1)) for cells in (rows, columns)]
    sums = np.add.reduceat(np.add.reduceat(picture, starts[0], axis=0), starts[1], axis=1)
    areas = np.outer(np.bincount(rows), np.bincount(columns)).astype(np.float32)
    means: np.ndarray = sums / areas.reshape(*areas.shape, *[1] * (picture.ndim - 2))
    return means
