"""Noise: grain, streaks, clouds."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated

import numpy as np

from vidstyle.block import (
    REDRAW_RATE,
    Choice,
    FrameTime,
    PageRegion,
    ResultRows,
    Slider,
    Switch,
    block,
    drawing_at,
)
from vidstyle.blocks.pixelate import whole_side
from vidstyle.core.kernels import cached, clipped_sum, compiled, interleaved, look_up_at
from vidstyle.core.white_noise import LATTICE_PART_SIZE, white_noise

OCTAVE_COUNTS = {"points": 0, "soft": 1, "clouds": 4}
"""Number of octaves of interpolated noise in each kind; 0 for uninterpolated points."""
LATTICE_COUNT = 16
"""Number of lattices per drawing: five for each channel, and one for `shift`."""
MAX_CODE = 65535
"""Highest code of cached noise."""
KEPT_BYTES = 1 << 28
"""Memory for all cached pages: four of 7680 x 4320 pixels."""


@block(
    "pixel",
    on="channels",
    label="Grain",
    category="texture",
    aliases=(
        "film grain, noise, paper texture, texture, canvas, old film, dust, analog, clouds, speckle, "
        "watercolor, watercolour, linen, vintage, old photo, spray, scratches"
    ),
)
def noise(
    picture: np.ndarray,
    place: PageRegion,
    moment: FrameTime,
    out: ResultRows,
    kind: Annotated[
        str,
        Choice(
            tuple(OCTAVE_COUNTS),
            "kind of noise: square points, soft points, or clouds",
            label="Kind of grain",
        ),
    ] = "soft",
    size: Annotated[
        float,
        Slider(
            1,
            256,
            "size of a point, or of the largest clouds",
            "px",
            (1, 12),
            label="Grain size",
            max_detail=1,
        ),
    ] = 1.5,
    stretch: Annotated[
        float,
        Slider(
            1, 64, "above 1, grain is this many times wider than high", explore=(1, 6), label="Grain stretch"
        ),
    ] = 1,
    amount: Annotated[
        float,
        Slider(
            0,
            1,
            "how much lighter and darker the grain is; 0 for none",
            explore=(0.05, 0.25),
            label="Grain amount",
        ),
    ] = 0.15,
    colored: Annotated[bool, Switch("grain in colours instead of gray", label="Coloured grain")] = False,
    rate: Annotated[int, REDRAW_RATE] = 0,
) -> np.ndarray:
    """Add grain, like film or rough paper.

    Random values with a mean of 0, which are fixed to the page and change only at `rate`. Points are
    rounded to whole pixels; soft points are interpolated by 3 t^2 - 2 t^3; clouds are four octaves of
    soft points. The result is clipped to 0..1. For blue noise, use `dither`.
    """
    sides = np.float32(size), np.float32(size) * np.float32(stretch)
    top, (height, width) = place.top, picture.shape[:2]
    drawing = drawing_at(moment, rate) * LATTICE_COUNT
    count = 3 if colored and picture.ndim == 3 else 1
    pages = [
        _codes(kind, sides, lattice, top, height, width)
        if rate
        else _kept_codes(kind, sides, lattice, place.height, width)[top : top + height]
        for lattice in (drawing + 5 * each for each in range(count))
    ]
    of_channels = tuple(pages * (3 // count))
    scale, middle = np.float32(amount / MAX_CODE), np.float32(amount / 2)
    _add(interleaved(picture), of_channels, scale, middle, interleaved(out))
    return out


@cached(maxsize=8, most_bytes=KEPT_BYTES)
def _kept_codes(
    kind: str, sides: tuple[np.float32, np.float32], lattice: int, height: int, width: int
) -> np.ndarray:
    """Return the codes of a whole page, cached for the last few pages, as they do not move."""
    return _codes(kind, sides, lattice, 0, height, width)


def _codes(
    kind: str, sides: tuple[np.float32, np.float32], lattice: int, top: int, height: int, width: int
) -> np.ndarray:
    """Return noise from 0 to `MAX_CODE`, height x width uint16."""
    codes = np.empty((height, width), np.uint16)
    _encode(_page(kind, sides, lattice, top, (height, width)), codes)
    return codes


@compiled
def _encode(page, codes):  # type: ignore[no-untyped-def]
    for row in range(codes.shape[0]):
        for x in range(codes.shape[1]):
            value = (page[row, x] + np.float32(0.5)) * np.float32(MAX_CODE) + np.float32(0.5)
            codes[row, x] = np.uint16(np.int32(value))


@compiled
def _add(picture, pages, scale, middle, out):  # type: ignore[no-untyped-def]
    """Add the pages of codes to red, green and blue, or the first to gray, and clip to 0..1."""
    first, second, third = pages
    for row in range(out.shape[0]):
        if out.shape[1] == first.shape[1]:
            for x in range(out.shape[1]):
                out[row, x] = clipped_sum(picture[row, x], scale * first[row, x] - middle)
        else:
            for x in range(first.shape[1]):
                i, j, k = 3 * x, 3 * x + 1, 3 * x + 2
                out[row, i] = clipped_sum(picture[row, i], scale * first[row, x] - middle)
                out[row, j] = clipped_sum(picture[row, j], scale * second[row, x] - middle)
                out[row, k] = clipped_sum(picture[row, k], scale * third[row, x] - middle)


def _page(
    kind: str, sides: tuple[np.float32, np.float32], lattice: int, top: int, shape: tuple[int, int]
) -> np.ndarray:
    """Return noise with a mean of 0 from this lattice on; `sides`: height and width of a point."""
    if kind == "points":
        rows = np.arange(top, top + shape[0]) // whole_side(sides[0])
        columns = np.arange(shape[1]) // whole_side(sides[1])
        points = lattice_points(lattice, rows[0], rows[-1] + 1, columns[-1] + 1)
        return points[np.ix_(rows - rows[0], columns)] - np.float32(0.5)
    total, whole = np.zeros(shape, np.float32), 2 - 2 * 0.5 ** OCTAVE_COUNTS[kind]
    for octave in range(OCTAVE_COUNTS[kind]):
        part = np.float32(0.5**octave)
        rows, down = between_points(top, shape[0], sides[0] * part)
        columns, right = between_points(0, shape[1], sides[1] * part)
        points = lattice_points(lattice + octave, rows[0], rows[-1] + 2, columns[-1] + 2)
        lines = np.empty(shape[1], np.float32), np.empty(shape[1], np.float32)
        _add_between(points, rows - rows[0], down, columns, right, np.float32(part / whole), lines, total)
    return total


def lattice_points(number: int, top: int, bottom: int, right: int) -> np.ndarray:
    """Return the points in these rows and columns of the lattice of an octave."""
    return white_noise(
        np.arange(top, bottom) + number * LATTICE_PART_SIZE, np.arange(right) + number * LATTICE_PART_SIZE
    )


@lru_cache(maxsize=64)
def between_points(first: int, count: int, size: np.float32) -> tuple[np.ndarray, np.ndarray]:
    """Return the point before each pixel of a row or column, and the weight of the next point."""
    places = (np.arange(first, first + count, dtype=np.float32) + np.float32(0.5)) * (np.float32(1) / size)
    points = np.floor(places)
    parts = places - points
    return points.astype(np.int64), parts * parts * (3 - 2 * parts)


@compiled
def _add_between(points, rows, down, columns, right, share, lines, total):  # type: ignore[no-untyped-def]
    """Add interpolated noise: horizontally for each row of points, then vertically for each row of pixels.

    Args:
        lines: scratch, two rows: the noise at the points above and below a pixel.
    """
    (upper, lower), present = lines, -2
    for row in range(total.shape[0]):
        if rows[row] != present:
            upper, lower = lower, upper
            if rows[row] != present + 1:
                _between_columns(points[rows[row]], columns, right, upper)
            _between_columns(points[rows[row] + 1], columns, right, lower)
            present = rows[row]
        below = down[row]
        for column in range(total.shape[1]):
            high, low = upper[column], lower[column]
            total[row, column] += share * (high + below * (low - high) - np.float32(0.5))


@compiled(noalias=True)
def _between_columns(points, columns, right, out):  # type: ignore[no-untyped-def]
    behind = points[1:]
    for column in range(out.size):
        left = look_up_at(columns[column])
        out[column] = points[left] + right[column] * (behind[left] - points[left])
