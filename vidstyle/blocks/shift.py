"""Shift: a plate out of register."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from vidstyle.block import (
    REDRAW_RATE,
    Choice,
    FrameTime,
    LumaWeights,
    PageRegion,
    ResultRows,
    Slider,
    block,
    drawing_at,
)
from vidstyle.blocks.noise import LATTICE_COUNT, between_points, lattice_points
from vidstyle.core.kernels import compiled, interleaved

PLATE_NAMES = ("all", "red", "green", "blue", "chroma")


def _radius(y: float, x: float, jitter: float) -> int:
    return math.ceil(max(abs(y), abs(x) + jitter)) + 1


@block(
    "filter",
    on="color",
    radius=_radius,
    label="Shift colours",
    category="texture",
    aliases=(
        "chromatic aberration, glitch, vhs, misregistration, colour fringe, rgb split, wobble, "
        "jitter, offset, move, tape, anaglyph, old television, old tv, wavy, ghosting, "
        "3d glasses, double vision, broken television, red and blue"
    ),
)
def shift(
    picture: np.ndarray,
    weights: LumaWeights,
    place: PageRegion,
    moment: FrameTime,
    out: ResultRows,
    plate: Annotated[
        str, Choice(PLATE_NAMES, "part of the picture to move", label="Part to shift")
    ] = "chroma",
    x: Annotated[
        float, Slider(-64, 64, "distance to the right", "px", (-6, 6), label="Shift to the right")
    ] = 4,
    y: Annotated[float, Slider(-64, 64, "down", "px", (-4, 4), label="Shift down")] = 0,
    jitter: Annotated[float, Slider(0, 64, "random sway of rows to both sides", "px", label="Wobble")] = 0,
    rate: Annotated[int, REDRAW_RATE] = 0,
) -> np.ndarray:
    """Move one colour out of place, like misprinted ink or worn tape.

    Moves one channel, the chroma or the whole picture. Fractions of a pixel are interpolated linearly.
    Rows sway in waves whose height is three times their width. The result is clipped to 0..1.
    """
    from_y = float(np.float32(-y))
    from_x = np.full(len(picture), -x, np.float32)
    if jitter:
        from_x -= np.float32(2 * jitter) * _waves(place.top, len(picture), jitter, drawing_at(moment, rate))
    down = math.floor(from_y), np.float32(from_y - math.floor(from_y))
    moved = np.array([plate in ("all", "chroma", each) for each in PLATE_NAMES[1:4]], np.uint8)
    line, own = np.empty(picture.shape[1] * 3, np.float32), weights * np.float32(plate == "chroma")
    _move(interleaved(picture), down, from_x, moved, own, place.margin[0], line, interleaved(out))
    return out


def _waves(top: int, count: int, jitter: float, drawing: int) -> np.ndarray:
    """Return the sway of each row, with a mean of 0."""
    rows, parts = between_points(top, count, np.float32(max(3 * jitter, 1)))
    lattice = drawing * LATTICE_COUNT + LATTICE_COUNT - 1
    points = lattice_points(lattice, rows[0], rows[-1] + 2, 1)[:, 0]
    before, after = points[rows - rows[0]], points[rows - rows[0] + 1]
    return before + parts * (after - before) - np.float32(0.5)


@compiled
def _move(picture, down, from_x, moved, weights, above, line, out):  # type: ignore[no-untyped-def]
    """Interpolate the moved channels between pixels; keep the original luma if there are weights.

    Args:
        above: number of the picture's rows above the first row of the result.
        line: scratch, one row.
    """
    last, width, zero, one = picture.shape[0] - 1, out.shape[1] // 3, np.float32(0), np.float32(1)
    first, second, third = moved[0] != 0, moved[1] != 0, moved[2] != 0
    is_whole = first and second and third and weights[0] == zero
    low, high = (zero, one) if is_whole else (np.float32(-np.inf), np.float32(np.inf))
    for row in range(out.shape[0]):
        here = row + above
        upper, lower = min(max(here + down[0], 0), last), min(max(here + down[0] + 1, 0), last)
        whole = int(np.floor(from_x[here]))
        part = from_x[here] - np.float32(whole)
        moved_row = out[row] if is_whole else line
        _between_pixels(picture[upper], picture[lower], whole, part, down[1], (low, high), moved_row)
        if is_whole:
            continue
        for x in range(width):
            red, green, blue = picture[here, 3 * x], picture[here, 3 * x + 1], picture[here, 3 * x + 2]
            r = line[3 * x] if first else red
            g = line[3 * x + 1] if second else green
            b = line[3 * x + 2] if third else blue
            added = weights[0] * (red - r) + weights[1] * (green - g) + weights[2] * (blue - b)
            out[row, 3 * x] = min(max(r + added, zero), one)
            out[row, 3 * x + 1] = min(max(g + added, zero), one)
            out[row, 3 * x + 2] = min(max(b + added, zero), one)


@compiled
def _between_pixels(upper, lower, whole, part, below, ends, line):  # type: ignore[no-untyped-def]
    """Interpolate between two rows, `whole` pixels and a part of one further right, and clip the result."""
    least, most = ends
    last = line.size // 3 - 1
    begin, end = min(max(-whole, 0), last + 1), max(min(last - whole, last + 1), 0)
    # Views, as an index that may be negative prevents vectorization.
    first = 3 * max(begin + whole, 0)
    high, low, inner = upper[first:], lower[first:], line[3 * begin :]
    for x in range(3 * (end - begin)):
        above = high[x] + part * (high[x + 3] - high[x])
        value = above + below * (low[x] + part * (low[x + 3] - low[x]) - above)
        inner[x] = min(max(value, least), most)
    for channel in range(3):  # the edge is repeated beyond the picture
        left, edge = upper[channel] + below * (lower[channel] - upper[channel]), 3 * last + channel
        for column in range(min(begin, last + 1)):
            line[3 * column + channel] = min(max(left, least), most)
        right = upper[edge] + below * (lower[edge] - upper[edge])
        for column in range(max(end, begin), last + 1):
            line[3 * column + channel] = min(max(right, least), most)
