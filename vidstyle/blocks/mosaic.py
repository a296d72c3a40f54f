"""Mosaic: irregular tiles of one colour each."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Color, PageRegion, Slider, block
from vidstyle.core.kernels import cached, compiled
from vidstyle.core.strokes import white_noise

AROUND = 2
"""Squares of the grid on each side in which a tile is looked for."""


def _radius(size: float) -> int:
    return math.ceil(AROUND * size) + 1


@block("filter", on="color", radius=_radius)
def mosaic(
    picture: np.ndarray,
    place: PageRegion,
    size: Annotated[float, Slider(3, 96, "size of a tile", "px", explore=(8, 32))] = 16,
    irregularity: Annotated[float, Slider(0, 1, "0 for squares")] = 0.8,
    gap: Annotated[float, Slider(0, 16, "width of the gap between tiles", "px", explore=(0, 3))] = 1.5,
    gap_color: Annotated[Any, Color("colour of the gap")] = "#1a1a1e",
    variation: Annotated[float, Slider(0, 1, "how much tiles differ in tone", explore=(0, 0.2))] = 0.06,
) -> np.ndarray:
    """Lay the picture in tiles of one colour each: stained glass, mosaic, cross stitch.

    Each tile is the Voronoi cell of a random point in a square of a grid that is fixed to the page, and has
    the colour of the picture there; smooth the picture first. Worley 1996, "A Cellular Texture Basis
    Function".
    """
    bottom = place.top + picture.shape[0]
    tiles = _tiles(size, irregularity, gap, place.height, place.width)
    rows, columns, tones, gaps = (each[place.top : bottom] for each in tiles)
    out = np.empty(picture.shape, np.float32)
    _fill(picture, (rows, columns, tones, gaps), place.top, np.float32(variation), np.float32(gap_color), out)
    return out


@cached(maxsize=4)
def _tiles(size: float, irregularity: float, gap: float, height: int, width: int) -> tuple[np.ndarray, ...]:
    """For each pixel of the page: row and column of the middle of its tile, its tone, and how much is gap.

    Kept for the last few pages, since the tiles do not move.
    """
    count = math.ceil(height / size) + 2 * AROUND, math.ceil(width / size) + 2 * AROUND
    rows, columns = (np.arange(-AROUND, each - AROUND) for each in count)
    numbers = white_noise(rows, np.arange(-3 * AROUND, 3 * (count[1] - AROUND))).reshape(*count, 3)
    spread = np.float32(irregularity)
    middles = np.empty((*count, 3), np.float32)
    middles[..., 0] = (columns + np.float32(0.5) + spread * (numbers[..., 0] - np.float32(0.5))) * np.float32(
        size
    )
    middles[..., 1] = (
        rows[:, None] + np.float32(0.5) + spread * (numbers[..., 1] - np.float32(0.5))
    ) * np.float32(size)
    middles[..., 2] = numbers[..., 2]
    places, shades = np.empty((2, height, width), np.int32), np.empty((2, height, width), np.float32)
    _divide(middles, np.float32(size), np.float32(gap / 2), places, shades)
    return *places, *shades


@compiled(fastmath=True)
def _divide(middles, size, half_gap, places, shades):  # type: ignore[no-untyped-def]
    """The nearest of the middles, and how far the border with the next tile is."""
    half, one, zero, far = np.float32(0.5), np.float32(1), np.float32(0), np.float32(1e9)
    height, width = places.shape[1], places.shape[2]
    for y in range(height):
        for x in range(width):
            here_x, here_y = np.float32(x) + half, np.float32(y) + half
            row, column = int(here_y / size) + AROUND, int(here_x / size) + AROUND
            nearest, best_row, best_column = far, row, column
            for i in range(row - 1, row + 2):
                for j in range(column - 1, column + 2):
                    dx, dy = middles[i, j, 0] - here_x, middles[i, j, 1] - here_y
                    if dx * dx + dy * dy < nearest:
                        nearest, best_row, best_column = dx * dx + dy * dy, i, j
            own_x, own_y, border = middles[best_row, best_column, 0], middles[best_row, best_column, 1], far
            for i in range(max(best_row - AROUND, 0), min(best_row + AROUND + 1, middles.shape[0])):
                for j in range(max(best_column - AROUND, 0), min(best_column + AROUND + 1, middles.shape[1])):
                    if i != best_row or j != best_column:
                        dx, dy = middles[i, j, 0] - own_x, middles[i, j, 1] - own_y
                        ahead = (own_x + half * dx - here_x) * dx + (own_y + half * dy - here_y) * dy
                        border = min(border, ahead / max(np.sqrt(dx * dx + dy * dy), np.float32(1e-6)))
            places[0, y, x] = min(max(int(np.floor(own_y)), 0), height - 1)
            places[1, y, x] = min(max(int(np.floor(own_x)), 0), width - 1)
            shades[0, y, x] = middles[best_row, best_column, 2]
            shades[1, y, x] = min(max(half_gap - border + half, zero), min(one, half_gap + half_gap))


@compiled
def _fill(picture, tiles, top, variation, gap_color, out):  # type: ignore[no-untyped-def]
    (rows, columns, tones, gaps), zero, one = tiles, np.float32(0), np.float32(1)
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            row = min(max(rows[y, x] - top, 0), out.shape[0] - 1)
            change = variation * (tones[y, x] - np.float32(0.5))
            for channel in range(3):
                color = min(max(picture[row, columns[y, x], channel] + change, zero), one)
                out[y, x, channel] = color + gaps[y, x] * (gap_color[channel] - color)
