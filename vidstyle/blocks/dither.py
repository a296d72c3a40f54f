"""Dither: a fixed pattern that makes few tones look like many."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Asset, PageRegion, Slider, block
from vidstyle.blocks.pattern import read_tile
from vidstyle.blocks.pixelate import whole_side
from vidstyle.core.kernels import compiled, interleaved


def shipped_thresholds() -> dict[str, Path]:
    """The tiles that come with vidstyle by name: Bayer's, and blue noise (tools/tables/blue_noise.py)."""
    return {file.stem: file for file in Path(__file__).with_name("thresholds").glob("*.png")}


def read_thresholds(path: Path) -> tuple[np.ndarray]:
    """The tones of a PNG by rank, so that each range of thresholds is as frequent as it is wide.

    Returns:
        One tile, H x W float32 between 0 and 1.

    Raises:
        ValueError: it is not a PNG, too large, or of one tone.
        OSError: it cannot be read.
    """
    tile = read_tile(path)
    tones, ranks, counts = np.unique(tile, return_inverse=True, return_counts=True)
    if len(tones) < 2:
        raise ValueError("has only one tone")
    middles = (np.cumsum(counts) - counts / 2) / tile.size
    return (middles[ranks].reshape(tile.shape).astype(np.float32),)


@block("pixel", on="channels")
def dither(
    picture: np.ndarray,
    place: PageRegion,
    thresholds: Annotated[
        Any, Asset("name of a pattern, or a .png tile", read_thresholds, shipped_thresholds)
    ] = "bayer4",
    strength: Annotated[
        float, Slider(0, 1, "1 for two tones after it, 1/n for n tones", explore=(0.1, 0.5))
    ] = 0.25,
    cell: Annotated[float, Slider(1, 64, "size of a point, rounded to whole pixels", "px", (1, 4))] = 1,
) -> np.ndarray:
    """Add a fixed pattern, so that the tones of a quantizer after it mix.

    Thresholds repeat over the page, about 0; the result is clipped to 0..1. Then quantize with `posterize`
    or `palette`. Bayer 1973; "blue" is blue noise, Ulichney 1993.
    """
    side, (tile,) = whole_side(cell), thresholds
    rows, columns = (np.arange(count) for count in picture.shape[:2])
    rows, columns = (rows + place.top) // side % tile.shape[0], columns // side % tile.shape[1]
    out = np.empty(picture.shape, np.float32)
    raised = np.float32(strength) * (tile - np.float32(0.5))
    _add(interleaved(picture), raised, rows, columns, np.empty(columns.size, np.float32), interleaved(out))
    return out


@compiled
def _add(picture, tile, rows, columns, line, out):  # type: ignore[no-untyped-def]
    """Add the numbers of a tile at these rows and columns to all channels, and clip to 0..1."""
    zero, one, channels = np.float32(0), np.float32(1), out.shape[1] // line.size
    for row in range(out.shape[0]):
        if row == 0 or rows[row] != rows[row - 1]:
            for x in range(line.size):
                line[x] = tile[rows[row], columns[x]]
        if channels == 1:
            for x in range(line.size):
                out[row, x] = min(max(picture[row, x] + line[x], zero), one)
        else:
            for x in range(line.size):
                for channel in range(3):
                    value = picture[row, 3 * x + channel] + line[x]
                    out[row, 3 * x + channel] = min(max(value, zero), one)
