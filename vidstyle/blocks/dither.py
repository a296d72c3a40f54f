"""Dither: a fixed pattern that makes few tones look like many."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vidstyle.block import SCATTERED_POINTS, Asset, PageRegion, ResultRows, Slider, block
from vidstyle.blocks.pattern import read_tile
from vidstyle.blocks.pixelate import whole_side
from vidstyle.core.kernels import clipped_sum, compiled, interleaved, look_up_at


def shipped_thresholds() -> dict[str, Path]:
    """Return the shipped tiles by name: Bayer's, and blue noise (tools/tables/blue_noise.py)."""
    return {file.stem: file for file in Path(__file__).with_name("thresholds").glob("*.png")}


def read_thresholds(path: Path) -> tuple[np.ndarray]:
    """Read the tones of a PNG, replaced by their rank so that thresholds are uniformly distributed.

    Returns:
        One tile, H x W float32 between 0 and 1.

    Raises:
        ValueError: the file is not a PNG, is too large, or has only one tone.
        OSError: the file cannot be read.
    """
    tile = read_tile(path)
    tones, ranks, counts = np.unique(tile, return_inverse=True, return_counts=True)
    if len(tones) < 2:
        raise ValueError("has only one tone")
    middles = (np.cumsum(counts) - counts / 2) / tile.size
    return (middles[ranks].reshape(tile.shape).astype(np.float32),)


@block(
    "pixel",
    on="channels",
    label="Dither",
    category="print",
    raster=lambda: SCATTERED_POINTS,
    aliases="8-bit, retro, old computer, game console, dots, stipple, stippling",
)
def dither(
    picture: np.ndarray,
    place: PageRegion,
    out: ResultRows,
    thresholds: Annotated[
        Any,
        Asset("name of a pattern, or a .png tile", read_thresholds, shipped_thresholds, label="Dot pattern"),
    ] = "bayer4",
    strength: Annotated[
        float,
        Slider(
            0,
            1,
            "1 before quantizing to two tones, 1/n before n tones",
            explore=(0.1, 0.5),
            label="Dither strength",
        ),
    ] = 0.25,
    cell: Annotated[
        float,
        Slider(
            1, 64, "size of a dot, rounded to whole pixels", "px", (1, 4), label="Dot size", max_detail=2.2
        ),
    ] = 1,
) -> np.ndarray:
    """Add a fixed pattern of dots, so that few tones or colours look like many.

    A following quantizer then mixes its tones. The pattern repeats over the page and has a mean of 0; the
    result is clipped to 0..1. Follow it with `posterize` or `palette`. Bayer 1973; "blue" is blue noise,
    Ulichney 1993.
    """
    side, (tile,) = whole_side(cell), thresholds
    line = np.empty(picture.shape[1], np.float32)
    columns = _columns(picture.shape[1], side, tile.shape[1])
    _add(interleaved(picture), tile, (place.top, side), columns, np.float32(strength), line, interleaved(out))
    return out


@lru_cache(maxsize=16)
def _columns(count: int, side: int, width: int) -> np.ndarray:
    """Return the column of the tile for each column of the page; `width`: of the tile."""
    return (np.arange(count) // side % width).astype(np.int32)


@compiled(noalias=True)
def _add(picture, tile, rows, columns, strength, line, out):  # type: ignore[no-untyped-def]
    """Add the tile to all channels.

    Args:
        rows: the number of the first row, and the number of rows for each row of the tile.
        line: scratch, the numbers to add to a row.
    """
    top, side = rows
    for row in range(out.shape[0]):
        if row == 0 or (top + row) % side == 0:
            values = tile[(top + row) // side % tile.shape[0]]
            for x in range(line.size):
                line[x] = strength * (values[look_up_at(columns[x])] - np.float32(0.5))
        if out.shape[1] == line.size:
            for x in range(line.size):
                out[row, x] = clipped_sum(picture[row, x], line[x])
        else:
            for x in range(line.size):
                i, j, k = 3 * x, 3 * x + 1, 3 * x + 2
                out[row, i] = clipped_sum(picture[row, i], line[x])
                out[row, j] = clipped_sum(picture[row, j], line[x])
                out[row, k] = clipped_sum(picture[row, k], line[x])
