"""Pixelate: large square pixels."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import PageRegion, Slider, block


def whole_side(size: float) -> int:
    """A length in pixels rounded as a GPU has it, halves up."""
    return int(np.float32(size) + np.float32(0.5))


@block("filter", on="channels", radius=lambda size: whole_side(size) - 1)
def pixelate(
    picture: np.ndarray,
    place: PageRegion,
    size: Annotated[float, Slider(1, 64, "side of a pixel, rounded to whole ones", "px", (3, 12))] = 6,
) -> np.ndarray:
    """Fill squares, which are fixed to the page, with their mean colour."""
    return cell_means(picture, place, whole_side(size), whole_side(size))


def cell_means(picture: np.ndarray, place: PageRegion, height: int, width: int) -> np.ndarray:
    """The mean over each pixel's cell, as far as the page goes.

    Args:
        height, width: of a cell; the picture has all rows of those that count.
    """
    rows = np.arange(place.top, place.top + picture.shape[0]) // height
    columns = np.arange(picture.shape[1]) // width
    starts = [np.flatnonzero(np.diff(cells, prepend=-1)) for cells in (rows, columns)]
    counts = [np.diff(first, append=len(cells)) for first, cells in zip(starts, (rows, columns), strict=True)]
    sums = np.add.reduceat(np.add.reduceat(picture, starts[0], axis=0), starts[1], axis=1)
    areas = (counts[0][:, None] * counts[1][None]).astype(np.float32)
    means = sums / areas.reshape(*areas.shape, *[1] * (picture.ndim - 2))
    return np.repeat(np.repeat(means, counts[1], axis=1), counts[0], axis=0)
