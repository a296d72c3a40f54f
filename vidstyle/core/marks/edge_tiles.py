"""Tiles whose sides follow the edges of a picture: kernels of `mosaic`."""

from __future__ import annotations

import math

import numpy as np

from vidstyle.core.kernels import compiled, look_up_at

NEAR_CELLS = 2
"""Squares of the grid on each side that are searched for the nearest tile."""
COLOR_WEIGHT = 30.0
"""Weight of the squared difference of two colours, 0..3, next to the squared distance in sizes of a tile."""


def border_offsets(gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the pixels near a pixel that make it part of the gap if they belong to another tile.

    Returns:
        Rows and columns relative to the pixel, n x 2 int32, nearest first, and the share of it that is gap,
        n float32.
    """
    reach = math.ceil(gap / 2)
    places = np.argwhere(np.ones((2 * reach + 1, 2 * reach + 1))) - reach
    covers = np.minimum(gap / 2 + 1 - np.hypot(*places.T), min(1, gap))
    nearest = np.argsort(-covers, kind="stable")[: np.count_nonzero(covers > 0)]
    nearest = nearest[np.any(places[nearest] != 0, axis=1)]
    return places[nearest].astype(np.int32), covers[nearest].astype(np.float32)


@compiled(fastmath=True, noalias=True)
def find_tiles(picture, top, squares, tiles, colors, scale, planes, best, owners):  # type: ignore[no-untyped-def]
    """Find the tile of each pixel: the one around it that is nearest in place and colour.

    Args:
        picture: the rows to divide, with interleaved channels; `top` is the first one's row on the page.
        squares: the square of the grid of each row, and the first column of each square and the end of the
            last one, and the square of the first row of `tiles`.
        tiles: column and row of the middle of each tile, and its distance from its square, in squares.
        colors: of the tiles.
        scale: side of a square, and weights of squared distances and of squared differences of colour.
        planes, best: scratch for a row: its channels, and the least distances.
        owners: the numbers of tiles, written.
    """
    (rows, starts, first), (middles, shifts), (size, nearness, likeness) = squares, tiles, scale
    half, zero = np.float32(0.5), np.float32(0)
    red, green, blue = planes[0], planes[1], planes[2]
    for y in range(owners.shape[0]):
        line, owner, here_y = picture[y], owners[y], np.float32(y + top) + half
        for x in range(owner.size):
            red[x] = min(max(line[3 * x], np.float32(0)), np.float32(1))
            green[x] = min(max(line[3 * x + 1], np.float32(0)), np.float32(1))
            blue[x] = min(max(line[3 * x + 2], np.float32(0)), np.float32(1))
            best[x] = np.float32(1e9)
        for square in range(starts.size - 1):
            # Where tiles have moved by half a square, their squares have, too.
            own = rows[y] - first
            right, down = shifts[own, square + NEAR_CELLS, 0], shifts[own, square + NEAR_CELLS, 1]
            row = own if down == zero else np.int32(np.floor(here_y / size - down)) - first
            middle = square + NEAR_CELLS
            left, end = middle - (2 if right > zero else 1), middle + (3 if right < zero else 2)
            for i in range(row - 1, row + 2):
                for j in range(left, end):
                    number, x_of, dy = (
                        np.int32(i * middles.shape[1] + j),
                        middles[i, j, 0],
                        middles[i, j, 1] - here_y,
                    )
                    r, g, b = colors[i, j, 0], colors[i, j, 1], colors[i, j, 2]
                    for x in range(starts[square], starts[square + 1]):
                        dx, dr, dg, db = x_of - (np.float32(x) + half), red[x] - r, green[x] - g, blue[x] - b
                        away = nearness * (dx * dx + dy * dy) + likeness * (dr * dr + dg * dg + db * db)
                        is_nearer = away < best[x]
                        best[x] = away if is_nearer else best[x]
                        owner[x] = number if is_nearer else owner[x]


@compiled(noalias=True)
def fill_tiles(owners, above, near, colors, gap_color, out):  # type: ignore[no-untyped-def]
    """Fill each tile with its colour, and the borders between tiles with the colour of the gap.

    Args:
        owners: the numbers of tiles; `above` is the number of its rows above the first one of `out`.
        near: from `border_offsets`.
        colors: of all tiles, flat.
    """
    (offsets, covers), last = near, np.int32(owners.shape[1] - 1)
    for y in range(out.shape[0]):
        row = y + above
        for x in range(owners.shape[1]):
            own, cover = owners[row, x], np.float32(0)
            for k in range(covers.size):
                i = min(max(row + offsets[k, 0], 0), owners.shape[0] - 1)
                j = min(max(np.int32(x) + offsets[k, 1], np.int32(0)), last)
                if owners[i, j] != own:
                    cover = covers[k]
                    break
            at = look_up_at(np.int32(3) * own)
            for channel in range(3):
                value = colors[channel:][at]
                out[y, 3 * x + channel] = value + cover * (gap_color[channel] - value)
