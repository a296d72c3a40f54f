"""Measures of thin strokes in squares of pixels, from which `cell_weights` tells writing.

A morphological closing fills thin dark strokes, so what it adds is the strokes. Light strokes are the dark
strokes of the negative. One call for all, as each call gives up the GIL and takes it back.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.regions.writing.morphology import (
    average_squares,
    filter_squares,
    greater,
    less,
    reflected,
)

ISLAND_RATIO = 5
"""Height of a bright word in a dark outline, relative to the thickness of strokes."""
EVEN_LEVEL_RATIO, EVEN_LEVEL = 0.13, 2
"""Ground is even where the wide closing adds less than this, relative to the strokes, and in 8-bit levels."""

LEVEL_COUNT, PRODUCT_COUNT = 5, 3
"""Measures of each kind; see `StrokeMeasures`."""
PLANE_COUNT = 6
"""Planes that `_measure` needs for its work."""


class StrokeMeasures(NamedTuple):
    """Measures of dark and of light strokes in a picture of half the size.

    Attributes:
        levels: 2 x 5 x H x W uint8: contrast of strokes; thin bright parts of the ground; 255 where ground
            is even; the strongest contrast nearby; ground that is only as large as a word.
        products: 2 x 3 x H x W int16: products of the slopes of strokes, across with across, down with down,
            and across with down.
    """

    levels: np.ndarray
    products: np.ndarray


def measure_strokes(luma: np.ndarray, thickness: int) -> StrokeMeasures:
    """Return measures of the strokes in a picture.

    Args:
        luma: H x W uint8, of at least 2 x 2 pixels.
        thickness: width of the squares that fill strokes, odd.
    """
    (height, width), margin = luma.shape, ISLAND_RATIO * thickness // 2 + 1
    half = round(height / 2), round(width / 2)
    planes = np.empty((PLANE_COUNT, height + 2 * margin, width + margin), np.uint8)
    measures = StrokeMeasures(
        np.empty((2, LEVEL_COUNT, *half), np.uint8), np.empty((2, PRODUCT_COUNT, *half), np.int16)
    )
    _measure(
        luma,
        (thickness, wide_size(thickness), ISLAND_RATIO * thickness, margin),
        (planes, planes.reshape(PLANE_COUNT, -1)),
        np.empty((2, width + thickness - 1), np.uint16),
        np.empty((2, half[1] + 2), np.int16),
        (np.float32(EVEN_LEVEL_RATIO), np.float32(EVEN_LEVEL)),
        *measures,
    )
    return measures


def wide_size(thickness: int) -> int:
    """Return the width of the squares that also fill what is wider than strokes, odd."""
    return 2 * thickness + 1


@compiled
def _measure(luma, sizes, planes, lines, slopes, even_level, levels, products):  # type: ignore[no-untyped-def]
    for side in range(2):
        _measure_side(luma, side == 1, sizes, planes, lines, even_level, levels[side])
        _multiply_slopes(levels[side, 0], slopes, products[side])


@compiled
def _measure_side(luma, is_negative, sizes, planes, lines, even_level, levels):  # type: ignore[no-untyped-def]
    """Measure one polarity.

    A dilated source serves two closings, and an eroded closing two openings.
    """
    (thick, wide, island, margin), (padded, flat) = sizes, planes
    source, closed, other, strokes, peaks, spare = flat[0], flat[1], flat[2], flat[3], flat[4], flat[5]
    height, padding = luma.shape[0], (padded.shape[2], margin)
    _copy_in(luma, is_negative, padded[0], margin)
    filter_squares(greater, 0, source, thick, padding, spare, other)
    filter_squares(less, 255, other, thick, padding, spare, closed)
    _subtract(closed, source, strokes)
    _halve(strokes, luma.shape, padding, lines[0], levels[0])
    filter_squares(greater, 0, strokes, thick, padding, spare, peaks)
    average_squares(peaks, thick, padding, height, lines, strokes)
    _halve(strokes, luma.shape, padding, lines[0], levels[3])
    filter_squares(greater, 0, other, wide - thick + 1, padding, spare, other)
    filter_squares(less, 255, other, wide, padding, spare, other)
    _find_even(other, source, strokes, even_level, other)
    _halve(other, luma.shape, padding, lines[0], levels[2])
    filter_squares(less, 255, closed, thick, padding, spare, other)
    filter_squares(greater, 0, other, thick, padding, spare, source)
    _subtract(closed, source, source)
    _halve(source, luma.shape, padding, lines[0], levels[1])
    filter_squares(less, 255, other, island - thick + 1, padding, spare, other)
    filter_squares(greater, 0, other, island, padding, spare, other)
    _subtract(closed, other, other)
    _halve(other, luma.shape, padding, lines[0], levels[4])


@compiled
def _copy_in(luma, is_negative, padded, margin):  # type: ignore[no-untyped-def]
    for y in range(luma.shape[0]):
        _copy_row(luma[y], np.uint8(255 if is_negative else 0), padded[margin + y])


@compiled(noalias=True)
def _copy_row(numbers, flip, out):  # type: ignore[no-untyped-def]
    for x in range(numbers.size):
        out[x] = numbers[x] ^ flip


@compiled
def _subtract(one, other, out):  # type: ignore[no-untyped-def]
    for place in range(out.size):
        out[place] = max(one[place], other[place]) - other[place]


@compiled
def _find_even(wide, source, peaks, even_level, out):  # type: ignore[no-untyped-def]
    ratio, level = even_level
    for place in range(out.size):
        limit = np.int32(np.rint(np.float32(peaks[place]) * ratio + level))
        out[place] = 255 if np.int32(wide[place]) - np.int32(source[place]) < limit else 0


@compiled
def _halve(plane, shape, padding, line, out):  # type: ignore[no-untyped-def]
    """Compute the means of squares of 2 x 2 pixels, and of what a border leaves of them."""
    (height, width), (pitch, margin) = shape, padding
    for y in range(out.shape[0]):
        start = (margin + 2 * y) * pitch
        is_whole = 2 * y + 1 < height
        last = start + pitch if is_whole else start
        _add_rows(plane[start : start + width], plane[last : last + width], line)
        if is_whole:
            _halve_row(line, out[y, : width // 2])
        for x in range(width // 2 if is_whole else 0, out.shape[1]):
            out[y, x] = _round_half(line[2 * x], line[min(2 * x + 1, width - 1)])


@compiled(noalias=True)
def _add_rows(one, other, out):  # type: ignore[no-untyped-def]
    for x in range(one.size):
        out[x] = one[x] + other[x]


@compiled(noalias=True)
def _halve_row(line, out):  # type: ignore[no-untyped-def]
    for x in range(out.size):
        out[x] = (line[2 * x] + line[2 * x + 1] + 2) >> 2


@compiled
def _round_half(one, other):  # type: ignore[no-untyped-def]
    """The rounded mean of two sums of two numbers, to the even number between two."""
    total = one + other
    return (total + 1 + ((total >> 2) & 1)) >> 2


@compiled
def _multiply_slopes(pixels, line, products):  # type: ignore[no-untyped-def]
    """Compute products of slopes by Sobel's filter; the picture is reflected at its borders.

    Args:
        line: 2 x (W + 2) int16, overwritten.
    """
    height, width = pixels.shape
    for y in range(height):
        above, below = pixels[reflected(y - 1, height)], pixels[reflected(y + 1, height)]
        _combine_rows(above, pixels[y], below, line[0, 1:], line[1, 1:])
        for sums in line:
            sums[0], sums[width + 1] = sums[1 + reflected(-1, width)], sums[1 + reflected(width, width)]
        _multiply_row(line[0], line[1], products[0, y], products[1, y], products[2, y])


@compiled(noalias=True)
def _combine_rows(above, row, below, sums, differences):  # type: ignore[no-untyped-def]
    for x in range(row.size):
        sums[x] = above[x] + 2 * row[x] + below[x]
        differences[x] = np.int32(below[x]) - np.int32(above[x])


@compiled(noalias=True)
def _multiply_row(sums, differences, squares, others, mixed):  # type: ignore[no-untyped-def]
    for x in range(squares.size):
        across = np.int32(sums[x + 2]) - np.int32(sums[x])
        down = np.int32(differences[x]) + 2 * np.int32(differences[x + 1]) + np.int32(differences[x + 2])
        squares[x] = _round_256th(np.int32(across * across))
        others[x] = _round_256th(np.int32(down * down))
        mixed[x] = _round_256th(np.int32(across * down))


@compiled
def _round_256th(number):  # type: ignore[no-untyped-def]
    """A 256th of a number, rounded to the even number between two."""
    return np.int32(number + 127 + ((number >> 8) & 1)) >> 8
