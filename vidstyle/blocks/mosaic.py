"""Mosaic: irregular tiles of one colour each."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Color, Drift, PageRegion, ResultRows, Slider, block
from vidstyle.core.drift import drifted_noise
from vidstyle.core.kernels import cached, clipped_sum, compiled, interleaved, look_up_at
from vidstyle.core.marks.edge_tiles import COLOR_WEIGHT, NEAR_CELLS, border_offsets, fill_tiles, find_tiles


def _radius(size: float, gap: float, edges: float) -> int:
    # The nearest point is at most a diagonal away; the point of the most similar colour at most two
    # squares, and as it moves half a square more.
    return math.ceil(2.5 * size + gap / 2 if edges else 1.4143 * size) + 1


@block(
    "filter",
    on="color",
    radius=_radius,
    label="Mosaic",
    category="print",
    aliases=(
        "stained glass, tiles, cells, voronoi, cross stitch, crystal, polygons, low poly, lego, patchwork"
    ),
    moves=lambda edges: edges > 0,
)
def mosaic(
    picture: np.ndarray,
    place: PageRegion,
    drift: Drift,
    out: ResultRows,
    size: Annotated[
        float,
        Slider(3, 96, "size of a tile", "px", explore=(8, 32), label="Tile size", max_detail=3, finest=7),
    ] = 16,
    irregularity: Annotated[
        float, Slider(0, 1, "irregularity of the tiles; 0 for squares", label="Irregularity")
    ] = 0.8,
    gap: Annotated[
        float,
        Slider(0, 16, "width of the gap between tiles", "px", explore=(0, 3), label="Gap width"),
    ] = 1.5,
    gap_color: Annotated[Any, Color("colour of the gap", label="Gap colour")] = "#1a1a1e",
    variation: Annotated[
        float, Slider(0, 1, "variation of tone between tiles", explore=(0, 0.2), label="Tone variation")
    ] = 0.06,
    edges: Annotated[
        float,
        Slider(0, 1, "how closely sides follow edges; 0 for straight ones", label="Sides along edges"),
    ] = 0,
) -> np.ndarray:
    """Divide the picture into tiles of one colour each, as in stained glass, mosaic or cross stitch.

    Each tile is the Voronoi cell of a random point in a square of a grid. It has the picture's colour there,
    so smooth the picture first. Worley 1996, "A Cellular Texture Basis Function". With `edges`, pixels belong
    to the point that is nearest in place and colour: one step of SLIC, Achanta et al. 2012, "SLIC Superpixels
    Compared to State-of-the-Art Superpixel Methods"; in films, the points move with the objects. Without
    `edges`, they are fixed to the page.
    """
    if edges:
        grid, looks = (size, irregularity), (gap, np.float32(gap_color), variation, edges)
        return _along_edges(picture, place, drift, grid, looks, out)
    tiles, owners, gaps = _tiles(size, irregularity, gap, place.height, place.width)
    top = place.top + place.margin[0]
    bottom, colors = top + len(out), np.empty(tiles.shape, np.float32)
    # A pixel's tile belongs to its square or a neighbouring one; one extra row allows for rounding.
    near = slice(int(top / size) + NEAR_CELLS - 2, int(bottom / size) + NEAR_CELLS + 3)
    _color_tiles(interleaved(picture), place.top, tiles[near], np.float32(variation), colors[near])
    flat = colors.reshape(-1)
    _fill(owners[top:bottom], gaps[top:bottom], flat, np.float32(gap_color), interleaved(out))
    return out


def _along_edges(
    picture: np.ndarray,
    place: PageRegion,
    drift: np.ndarray | None,
    grid: tuple[float, float],
    looks: tuple[float, Any, float, float],
    out: np.ndarray,
) -> np.ndarray:
    """Divide the picture into tiles whose sides follow its edges.

    Args:
        grid: size and irregularity of tiles.
        looks: gap, its colour, variation and edges.
    """
    (size, irregularity), (gap, gap_color, variation, edges) = grid, looks
    near, rows = border_offsets(gap), interleaved(picture)
    above, below = (min(math.ceil(gap / 2), each) for each in place.margin)
    inner = slice(place.margin[0] - above, len(picture) - place.margin[1] + below)
    top = place.top + inner.start
    middles = np.arange(top, place.top + inner.stop, dtype=np.float32) + np.float32(0.5)
    squares = (middles / np.float32(size)).astype(np.int32)
    first, end = int(squares[0]) - NEAR_CELLS, int(squares[-1]) + NEAR_CELLS + 1
    if drift is None:
        kept = slice(first + NEAR_CELLS, end + NEAR_CELLS)
        tiles, shifts = (each[kept] for each in _points(size, irregularity, place.height, place.width))
    else:
        page = place.height, place.width
        tiles, shifts = _drifted_points(size, irregularity, (first, end), page, drift)
    colors = np.empty(tiles.shape, np.float32)
    _color_tiles(rows, place.top, tiles, np.float32(0), colors)
    owners = np.empty((inner.stop - inner.start, place.width), np.int32)
    planes, best = np.empty((3, place.width), np.float32), np.empty(place.width, np.float32)
    scale = np.float32(size), np.float32(1 / size**2), np.float32(edges * COLOR_WEIGHT)
    starts = _first_columns(size, place.width)
    find_tiles(
        rows[inner], top, (squares, starts, first), (tiles, shifts), colors, scale, planes, best, owners
    )
    _color_tiles(rows, place.top, tiles, np.float32(variation), colors)
    fill_tiles(owners, above, near, colors.reshape(-1), gap_color, interleaved(out))
    return out


@cached(maxsize=6)
def _first_columns(size: float, width: int) -> np.ndarray:
    """Return the first column of each square of the grid, and the end of the last one, int32."""
    columns = ((np.arange(width, dtype=np.float32) + np.float32(0.5)) / np.float32(size)).astype(np.int32)
    return np.searchsorted(columns, np.arange(columns[-1] + 2)).astype(np.int32)


@cached(maxsize=6)
def _tiles(size: float, irregularity: float, gap: float, height: int, width: int) -> tuple[np.ndarray, ...]:
    """Return the tiles of a page, cached as they do not move: for three blocks, on the page and on its faces.

    Returns:
        Column and row of the middle of each tile and its tone, rows x columns x 3; the number of each pixel's
        tile; the share of the pixel that is gap, in 255ths.
    """
    middles, _ = _points(size, irregularity, height, width)
    owners, gaps = np.empty((height, width), np.int32), np.empty((height, width), np.uint8)
    _divide(middles, np.float32(size), np.float32(gap / 2), owners, gaps)
    return middles, owners, gaps


@cached(maxsize=6)
def _points(size: float, irregularity: float, height: int, width: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of tiles that have not moved, cached for the next frame; see `_drifted_points`."""
    rows = -NEAR_CELLS, math.ceil(height / size) + NEAR_CELLS
    return _drifted_points(size, irregularity, rows, (height, width), None)


def _drifted_points(
    size: float,
    irregularity: float,
    rows: tuple[int, int],
    page: tuple[int, int],
    drift: np.ndarray | None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the tiles of a page, one for each square of a grid.

    Returns:
        Column and row of the middle of each tile, and its tone: rows x columns x 3; and its distance from
        its square, see `drifted_noise`.
    """
    columns = -NEAR_CELLS, math.ceil(page[1] / size) + NEAR_CELLS
    numbers, shifts = drifted_noise(drift, rows, columns, size, page, 3)
    half, spread, middles = np.float32(0.5), np.float32(irregularity), np.empty(numbers.shape, np.float32)
    for axis, square in enumerate((np.arange(*columns), np.arange(*rows)[:, None])):
        offset = spread * (numbers[..., axis] - half)
        offset = offset if drift is None else offset + shifts[..., axis]
        middles[..., axis] = (square + half + offset) * np.float32(size)
    middles[..., 2] = numbers[..., 2]
    return middles, shifts


@compiled(fastmath=True)
def _divide(middles, size, half_gap, owners, gaps):  # type: ignore[no-untyped-def]
    """Find the nearest middle for each pixel, and the distance to the border with the next tile."""
    half, one, zero, far = np.float32(0.5), np.float32(1), np.float32(0), np.float32(1e9)
    for y in range(owners.shape[0]):
        for x in range(owners.shape[1]):
            here_x, here_y = np.float32(x) + half, np.float32(y) + half
            row, column = int(here_y / size) + NEAR_CELLS, int(here_x / size) + NEAR_CELLS
            nearest, best_row, best_column = far, row, column
            for i in range(row - 1, row + 2):
                for j in range(column - 1, column + 2):
                    dx, dy = middles[i, j, 0] - here_x, middles[i, j, 1] - here_y
                    if dx * dx + dy * dy < nearest:
                        nearest, best_row, best_column = dx * dx + dy * dy, i, j
            own_x, own_y, border = middles[best_row, best_column, 0], middles[best_row, best_column, 1], far
            for i in range(max(best_row - NEAR_CELLS, 0), min(best_row + NEAR_CELLS + 1, middles.shape[0])):
                for j in range(
                    max(best_column - NEAR_CELLS, 0), min(best_column + NEAR_CELLS + 1, middles.shape[1])
                ):
                    if i != best_row or j != best_column:
                        dx, dy = middles[i, j, 0] - own_x, middles[i, j, 1] - own_y
                        ahead = (own_x + half * dx - here_x) * dx + (own_y + half * dy - here_y) * dy
                        border = min(border, ahead / max(np.sqrt(dx * dx + dy * dy), np.float32(1e-6)))
            owners[y, x] = best_row * middles.shape[1] + best_column
            cover = min(max(half_gap - border + half, zero), min(one, half_gap + half_gap))
            gaps[y, x] = int(cover * np.float32(255) + half)


@compiled
def _color_tiles(picture, top, tiles, variation, colors):  # type: ignore[no-untyped-def]
    """Compute the colour of each tile; valid only for tiles with pixels in these rows."""
    half = np.float32(0.5)
    for i in range(tiles.shape[0]):
        for j in range(tiles.shape[1]):
            x, y, tone = tiles[i, j, 0], tiles[i, j, 1], tiles[i, j, 2]
            column = min(max(int(np.floor(x)), 0), picture.shape[1] // 3 - 1)
            row = min(max(int(np.floor(y)) - top, 0), picture.shape[0] - 1)
            for channel in range(3):
                colors[i, j, channel] = clipped_sum(
                    picture[row, 3 * column + channel], variation * (tone - half)
                )


@compiled(noalias=True)
def _fill(owners, gaps, colors, gap_color, out):  # type: ignore[no-untyped-def]
    for y in range(owners.shape[0]):
        for x in range(owners.shape[1]):
            at, cover = look_up_at(np.int32(3) * owners[y, x]), gaps[y, x] * np.float32(1 / 255)
            red, green, blue = colors[at], colors[1:][at], colors[2:][at]
            out[y, 3 * x] = red + cover * (gap_color[0] - red)
            out[y, 3 * x + 1] = green + cover * (gap_color[1] - green)
            out[y, 3 * x + 2] = blue + cover * (gap_color[2] - blue)
