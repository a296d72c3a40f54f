"""Halftone: the four-colour print process."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated

import cv2
import numpy as np

from vidstyle.block import Choice, PageRegion, Raster, Slider, block
from vidstyle.core.kernels import compiled, index_at, interleaved, look_up_at

SCREEN_DEGREES = (15.0, 75.0, 0.0, 45.0)
"""Angles of the screens of cyan, magenta, yellow and black."""

INK_COLORS = {
    "pure": ((0, 1, 1), (1, 0, 1), (1, 1, 0), (0, 0, 0)),
    "press": ((0, 0.62, 0.88), (0.87, 0.07, 0.5), (1, 0.9, 0.08), (0.13, 0.12, 0.13)),
}
"""Red, green and blue of each ink on white paper; `press` approximates ISO coated."""

REACH_CELLS, REACH_PX = 0.75, 1
"""The centre of a cell that touches a row is at most this far from the row; the two are added."""


def _radius(cell: float) -> int:
    # A dot's centre is at most half a diagonal away, and its ink is averaged over half a cell around the
    # centre.
    return math.ceil(cell * 0.7072 + cell / 2) + 2


@block(
    "filter",
    on="color",
    radius=_radius,
    raster=lambda cell: Raster.of_screens(cell, SCREEN_DEGREES),
    label="Halftone dots",
    category="print",
    aliases="dots, newspaper, comic, pop art, raster, cmyk, magazine, printed, benday, newsprint",
)
def halftone(
    picture: np.ndarray,
    place: PageRegion,
    cell: Annotated[
        float,
        Slider(
            2, 64, "distance between dots", "px", explore=(4, 12), label="Dot size", max_detail=1, finest=3
        ),
    ] = 6,
    dot: Annotated[
        float, Slider(0.2, 1.5, "amount of ink; below 1 even black areas show dots", label="Amount of ink")
    ] = 1,
    gain: Annotated[float, Slider(0, 0.4, "dot gain in the midtones", label="Dot gain")] = 0.15,
    black: Annotated[
        float, Slider(0, 1, "share of the dark tones printed with black ink", label="Black ink")
    ] = 0.9,
    inks: Annotated[
        str, Choice(tuple(INK_COLORS), "ink colours: pure, or as on a printing press", label="Ink colours")
    ] = "press",
) -> np.ndarray:
    """Print the picture in dots of cyan, magenta, yellow and black ink.

    The screens have angles of 15, 75, 0 and 45 degrees and are fixed to the page. The ink of a dot is
    averaged over its cell. Dots touch at half coverage; above it, inverted dots remain. Edges are
    anti-aliased. Paper, section 4.2 B; dot gain a + 4 g a (1 - a).
    """
    # float32 as on a GPU: over a long page, the rounding difference would add up to another pixel under a
    # dot.
    cell = float(np.float32(cell))
    side = 2 * int(cell / 2) + 1
    averaged = cv2.blur(picture, (side, side), borderType=cv2.BORDER_REPLICATE)
    spread = np.float32(dot), np.float32(gain), np.float32(black)
    screens, cells = _screens(cell, place.top, *picture.shape[:2])
    cover, dots = np.empty((4, picture.shape[1]), np.float32), np.empty(4, np.int32)
    scratch = np.empty(cells, np.float32), cover, dots
    out, places = np.empty(picture.shape, np.float32), (place.top, place.margin)
    _print(averaged.reshape(-1), screens, places, spread, _ink_colors(inks), scratch, interleaved(out))
    return out


@lru_cache(maxsize=256)
def _screens(cell: float, top: int, height: int, width: int) -> tuple[np.ndarray, int]:
    """Find the cells that rows of the page touch, one lattice for each ink.

    Returns:
        4 x 8 float64: cosine and sine of the angle divided by the cell size, first cell along and across the
        screen, number of cells along and across, index of the first cell among the cells of all inks, and
        distance between the indices of neighbours along. Second, the total number of cells.
    """
    screens, cells = np.empty((4, 8)), 0
    corners = [(x, y) for x in (0, width) for y in (top, top + height)]
    for screen, angle in zip(screens, map(math.radians, SCREEN_DEGREES), strict=True):
        cosine, sine = math.cos(angle) / cell, math.sin(angle) / cell
        along = [math.floor(x * cosine + y * sine) for x, y in corners]
        across = [math.floor(y * cosine - x * sine) for x, y in corners]
        rows, columns = (max(each) - min(each) + 3 for each in (along, across))
        # The rows fill only a diagonal of a wide lattice: lines of cells overlap where no row touches them.
        touched = (height + 2 * (REACH_CELLS * cell + REACH_PX)) / (cosine * cell * cell) + 3
        stride = min(columns, math.ceil(touched) + math.ceil(sine / cosine))
        screen[:] = cosine, sine, min(along) - 1, min(across) - 1, rows, columns, cells, stride
        cells += (rows - 1) * stride + columns
    return screens, cells


@lru_cache
def _ink_colors(inks: str) -> np.ndarray:
    return np.array(INK_COLORS[inks], np.float32)


@compiled(noalias=True)
def _ink_levels(averaged, shape, ink, screen, top, spread, levels):  # type: ignore[no-untyped-def]
    """Compute for each cell the height at which to cut the screen so that the dot has the right coverage.

    Returns:
        The number of dots with ink.
    """
    cosine, sine, first, second = screen[0], screen[1], screen[2], screen[3]
    rows, columns, start, stride = int(screen[4]), int(screen[5]), int(screen[6]), int(screen[7])
    dot, gain, black = spread
    height, width = np.int32(shape[0]), np.int32(shape[1])
    squared = cosine * cosine + sine * sine
    per_pixel = np.float32(np.sqrt(squared))
    one, dots = np.float32(1), np.int32(0)
    near = REACH_CELLS / per_pixel + REACH_PX
    inverse = 1 / squared
    for i in range(rows):
        along = (first + i + 0.5) * inverse
        # The rotated band fills only a small part of the lattice: visit only the cells near its rows.
        begin = ((top - near - along * sine) / cosine) * squared - second - 0.5
        end = ((top + height + near - along * sine) / cosine) * squared - second - 0.5
        left, right = max(int(begin), 0), min(int(end) + 2, columns)
        # A view, as an index that may be negative prevents vectorization.
        row = levels[start + i * stride + left :]
        for j in range(right - left):
            across = (second + (left + j) + 0.5) * inverse
            x = index_at(np.floor(along * cosine - across * sine + 5e-5), width - 1)
            y = index_at(np.floor(along * sine + across * cosine + 5e-5) - top, height - 1)
            at = look_up_at(np.int32(3) * np.int32(np.int32(y * width) + x))
            red, green, blue = averaged[at], averaged[1:][at], averaged[2:][at]
            key = black * (one - max(red, max(green, blue)))
            if ink == 3:
                share = key
            else:
                value = red if ink == 0 else green if ink == 1 else blue
                share = (one - value - key) / max(one - key, np.float32(1e-3))
            share = min(min(max(share, np.float32(0)), one) * dot, one)
            share = min(share + np.float32(4) * gain * share * (one - share), one)
            row[j] = _cut(share, per_pixel)
            dots = np.int32(dots + np.int32(share > 0))
    return dots


@compiled
def _cut(share, per_pixel):  # type: ignore[no-untyped-def]
    """Return the height above which the screen has this share of its area, 0..1.

    The polynomial approximates the inverse of the distribution of the screen's heights; its error is at most
    0.6 % of the area. The last term keeps the softened edge out of cells without ink and of fully covered
    cells.
    """
    x = np.float32(1) - np.float32(2) * share
    x2 = x * x
    x4 = x2 * x2
    odd = np.float32(0.25987756) + np.float32(0.46864727) * x2
    odd += np.float32(-0.43836827) * x4 + np.float32(0.20984343) * x4 * x2
    lift = per_pixel * (np.float32(1.5) * per_pixel + np.float32(0.25))
    return np.float32(0.5) + x * (odd + lift * x2 * x4 * x4 * x4)


@compiled(fastmath=True, noalias=True)
def _cover_row(levels, screen, y, cover):  # type: ignore[no-untyped-def]
    """Compute the coverage of each pixel of a row by one ink."""
    one, half, two, three = np.float32(1), np.float32(0.5), np.float32(2), np.float32(3)
    cosine, sine = screen[0], screen[1]
    per_pixel = np.float32(np.sqrt(cosine * cosine + sine * sine))
    # The slope of the height, in cells, is 6 times a root, and at least 0.5.
    gentle, flattest = one / (np.float32(6) * per_pixel), np.float32((0.5 / 6) ** 2)
    step, turn, width = np.float32(cosine), np.float32(sine), cover.shape[0]
    # Relative to the lowest cell of the row, not of the band, so that float32 rounds identically in every
    # band.
    first, second = np.floor(0.5 * cosine + y * sine), np.floor(y * cosine - width * sine)
    start, side = np.float32(0.5 * cosine + y * sine - first), np.float32(y * cosine - 0.5 * sine - second)
    lift = np.float32(1e-4) * per_pixel
    stride = np.int32(screen[7])
    origin = np.int32(np.int32(first - screen[2]) * stride + np.int32(second - screen[3] + screen[6]))
    last = np.int32(levels.size - 1)
    for x in range(width):
        along, across = start + np.float32(np.int32(x)) * step, side - np.float32(np.int32(x)) * turn
        i, j = np.int32(along + lift), np.int32(across + lift)
        s, t = abs(two * (along - np.float32(i)) - one), abs(two * (across - np.float32(j)) - one)
        down, right = s * (one - s), t * (one - t)
        height = one - half * (s * s * (three - two * s) + t * t * (three - two * t))
        flatness = one / np.sqrt(max(down * down + right * right, flattest))
        cell = look_up_at(min(np.int32(np.int32(i * stride) + np.int32(origin + j)), last))
        cover[x] = min(max((height - levels[cell]) * (flatness * gentle) + half, np.float32(0)), one)


@compiled(fastmath=True)
def _print(averaged, screens, places, spread, inks, scratch, out):  # type: ignore[no-untyped-def]
    """Multiply white paper by the transmission of the dots of each ink.

    Args:
        places: the number of the first row on the page, and the margin.
        scratch: one number per cell, one row per ink, and one number per ink.
    """
    (top, margin), (levels, cover, dots) = places, scratch
    shape, cover[:] = (out.shape[0], cover.shape[1]), np.float32(0)
    for ink in range(4):
        dots[ink] = _ink_levels(averaged, shape, ink, screens[ink], top, spread, levels)
    for row in range(margin[0], out.shape[0] - margin[1]):
        for ink in range(4):
            if dots[ink] > 0:
                _cover_row(levels, screens[ink], top + row + 0.5, cover[ink])
        _mix_inks(cover[0], cover[1], cover[2], cover[3], inks, out[row])


@compiled(fastmath=True)
def _mix_inks(cyan, magenta, yellow, black, inks, out):  # type: ignore[no-untyped-def]
    one = np.float32(1)
    a, b, c, d = one - inks[0, 0], one - inks[1, 0], one - inks[2, 0], one - inks[3, 0]
    e, f, g, h = one - inks[0, 1], one - inks[1, 1], one - inks[2, 1], one - inks[3, 1]
    i, j, k, m = one - inks[0, 2], one - inks[1, 2], one - inks[2, 2], one - inks[3, 2]
    for x in range(cyan.shape[0]):
        p, q, r, s = cyan[x], magenta[x], yellow[x], black[x]
        out[3 * x] = (one - a * p) * (one - b * q) * (one - c * r) * (one - d * s)
        out[3 * x + 1] = (one - e * p) * (one - f * q) * (one - g * r) * (one - h * s)
        out[3 * x + 2] = (one - i * p) * (one - j * q) * (one - k * r) * (one - m * s)
