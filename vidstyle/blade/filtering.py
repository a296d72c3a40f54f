"""Applies the selected filters to a plane on the CPU. Paper, section 5.1, equation 2."""

from __future__ import annotations

import numpy as np

from vidstyle.blade.clipped import add_clipped
from vidstyle.blade.simd import filter_pixel_block
from vidstyle.core.kernels import CACHE_LINE_FLOATS, aligned_parts, compiled, round_up
from vidstyle.core.picture import WIDE_RANGE

ROWS_AT_ONCE = 3
"""Rows of pixels that are filtered together if each pixel has its own filter."""


def apply_filters(
    luma: np.ndarray,
    selected: np.ndarray,
    packed: np.ndarray,
    size: int,
    limits: tuple[float, float],
    margin: tuple[int, int] = (0, 0),
    step: int = 1,
    top: int = 0,
    out: np.ndarray | None = None,
    constants: np.ndarray | None = None,
    clipped: tuple[np.ndarray, tuple[float, ...]] | None = None,
) -> np.ndarray:
    """Filter each pixel with the filter selected for it.

    Args:
        luma: H x W float32; beyond its border the border is repeated.
        selected: from `choose_filters`.
        packed: from `pack_filters`.
        size: rows and columns of a filter.
        limits: the range that the result is clipped to.
        margin: numbers of first and last rows that are not needed.
        step: side of the squares of pixels that share a filter.
        top: as in `select_filters`.
        out: float32, rows without the margin.
        constants: one for each filter, to add to its result before clipping.
        clipped: weights of clipped differences, from `pack_clipped`, and the clips, also to add.

    Returns:
        `out` if it consists of whole cache lines and squares; otherwise H x W float32, undefined in the
        margin.
    """
    (height, width), lead = luma.shape, top % step
    columns = round_up(width, CACHE_LINE_FLOATS)
    rows = (margin[0] + lead) // step, -(-(height - margin[1] + lead) // step)
    together = 1 if step > 1 else min(ROWS_AT_ONCE, rows[1] - rows[0])
    shape = size + together * step - 1, columns + round_up(size, CACHE_LINE_FLOATS) + CACHE_LINE_FLOATS
    kept, again = aligned_parts(shape, (shape[0] * shape[1] + CACHE_LINE_FLOATS,))
    # Pixels that start within a cache line read rows that also start within one.
    around = kept, again[CACHE_LINE_FLOATS // 2 : -CACHE_LINE_FLOATS // 2].reshape(shape)
    is_extended = constants is not None or clipped is not None
    low, high = WIDE_RANGE if is_extended else limits
    ends = np.float32(low), np.float32(high)
    if (
        out is None
        or width % CACHE_LINE_FLOATS
        or any((row + lead) % step for row in (margin[0], height - margin[1]))
    ):
        out, first = np.empty((len(selected) * step, columns), np.float32), 0
        result = out[lead : lead + height, :width]
    else:
        result, first = out, rows[0]
    chosen = _widened(selected, columns // step)
    sides = (0,) * size, (0,) * step, (0,) * together
    _apply(np.ascontiguousarray(luma), chosen, packed, sides, (*rows, lead, first), ends, around, out)
    if is_extended:
        needed = slice(margin[0], height - margin[1])
        inside = result if result is out else result[needed]
        if clipped is not None:
            add_clipped(inside, luma, margin[0], selected[needed], clipped[0], size, clipped[1])
        added = np.zeros(len(packed), np.float32) if constants is None else constants
        _add_constants(inside, selected[needed], added, np.float32(limits[0]), np.float32(limits[1]))
    return result


def _widened(selected: np.ndarray, columns: int) -> np.ndarray:
    """Return the indices with this number of columns: the base array of `selected`, or a copy."""
    if selected.base is not None and selected.base.shape == (len(selected), columns):
        return selected.base
    return np.pad(selected, ((0, 0), (0, columns - selected.shape[1]))).astype(np.int32)


@compiled(fastmath=True)
def _add_constants(out, selected, constants, low, high):  # type: ignore[no-untyped-def]
    """Add the constant of each pixel's filter, and clip; a constant belongs to one pixel, not to a square."""
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            out[row, x] = min(max(out[row, x] + constants[selected[row, x]], low), high)


@compiled(fastmath=True)
def _apply(luma, selected, filters, sides, place, ends, around, out):  # type: ignore[no-untyped-def]
    """Filter the squares, several rows at a time; the last rows may be filtered twice.

    Args:
        sides: as in `filter_pixel_block`.
        place: the first row of squares, the row after the last, rows of the first square above luma, and the
            row of squares at the start of `out`.
        ends: ends of the range that the result is clipped to.
        around: rows of luma with their border, stored twice.
    """
    (top, bottom, lead, first), (low, high), (kept, again) = place, ends, around
    radius, step, together = len(sides[0]) // 2, len(sides[1]), len(sides[2])
    count, last = kept.shape[0], luma.shape[0] - 1
    begun = top * step - lead - radius
    for next_row in range(top, bottom, together):
        row = min(next_row, bottom - together)
        end = row * step - lead - radius + count
        for each in range(begun, end):
            _repeat_border(luma[min(max(each, 0), last)], radius, kept[each % count], again[each % count])
        begun, oldest = end, end % count
        chosen, filtered = selected[row:], out[(row - first) * step :]
        for column in range(0, out.shape[1], 16):
            filter_pixel_block(filters, chosen, kept, oldest, column, sides, low, high, filtered)
            filter_pixel_block(filters, chosen, again, oldest, column + 8, sides, low, high, filtered)


@compiled(fastmath=True, noalias=True)
def _repeat_border(row, radius, out, again):  # type: ignore[no-untyped-def]
    """Extend a row by `radius` copies of its first and last numbers, and store it twice."""
    inside, inside_again, end = out[radius:], again[radius:], radius + row.size
    for x in range(radius):
        out[x], again[x] = row[0], row[0]
    for x in range(row.size):
        inside[x], inside_again[x] = row[x], row[x]
    for x in range(end, out.size):
        out[x], again[x] = row[row.size - 1], row[row.size - 1]
