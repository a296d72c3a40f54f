"""Kernels that blend 16-bit planes with 16-bit arithmetic: vectors hold twice as many numbers as with floats.

A product is the upper half of 32 bits, rounded down. If a value is the sum of two products, 1 is added, so
that repeated blending does not darken it.
"""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.stabilize.segment import SEGMENT_SIZE
from vidstyle.stabilize.warp import LINE_COUNT, grid_row, has_moved, warp_group

FULL_WEIGHT = 255
"""The stored form of the weight 1."""
LIMIT_STEPS = 17
"""Maximum steps of change up to the limit, so that the sum of nine squares does not overflow before the
weight is 0."""


@compiled
def source_code_rows(plane, before, samples, moves, guide, step, numbers, rows, scratch, weights, out):  # type: ignore[no-untyped-def]
    """See `blend.source_rows`.

    Args:
        numbers: uint16: gain from codes to 16-bit codes, and the amount then subtracted; half a step of
            change, and the binary logarithm of the step; weight of the previous plane, 1 as 257. And float32:
            1 / (9 limit^2), with the limit in steps.
    """
    across, down = step
    codes, rate = numbers
    lines, (squares, columns), others, (stored, ones), beside = scratch
    (top, bottom), last, factors = rows, plane.shape[0] - 1, others[2]
    warped = compared = max(top - 1, 0)
    for y in range(top, bottom):
        while compared <= min(y + 1, last):
            if compared == warped:
                warped = warp_group(before, samples, warped, min(bottom, last) + 1, moves, beside, lines)
            old = lines[compared % LINE_COUNT] if has_moved(compared, last + 1, moves) else before[compared]
            _change_of_row(plane[compared], codes, old, others[compared % 2], squares[compared % 3])
            compared += 1
        _add_rows(squares[max(y - 1, 0) % 3], squares[y % 3], squares[min(y + 1, last) % 3], columns)
        if guide.size > 1:
            _row_weights(columns, rate, stored)
            _set_factors(stored, guide[y * down], across, codes[4], factors)
        else:
            _row_weights(columns, rate, weights[y])
            _set_factors(ones, weights[y], 1, codes[4], factors)
        old = lines[y % LINE_COUNT] if has_moved(y, last + 1, moves) else before[y]
        _blend_row(others[y % 2], old, factors, out[y])


@compiled
def result_code_rows(plane, before, samples, moves, parts, guide, step, numbers, rows, scratch, out, codes):  # type: ignore[no-untyped-def]
    """See `blend.result_rows`.

    Args:
        parts: stored weights of segments, h x w.
        numbers: uint16: gain from codes to 16-bit codes, half of it, and its binary logarithm; weight of the
            previous plane, 1 as 257.
    """
    across, down = step
    (lines, factors, of_row, beside), filled, warped = scratch, -1, rows[0]
    for y in range(rows[0], rows[1]):
        if y == warped:
            warped = warp_group(before, samples, y, rows[1], moves, beside, lines)
        place = grid_row(y, plane.shape[0], parts.shape[0])
        if place != filled:
            for x in range(of_row.size):
                of_row[x] = parts[place, x // SEGMENT_SIZE]
            filled = place
        _set_factors(of_row, guide[y * down], across, numbers[3], factors)
        old = lines[y % LINE_COUNT] if has_moved(y, plane.shape[0], moves) else before[y]
        _blend_result(plane[y], numbers, old, factors, out[y], codes[y])


@compiled
def _upper(first, second):  # type: ignore[no-untyped-def]
    return np.uint16(np.uint32(np.uint32(first) * np.uint32(second)) >> np.uint32(16))


@compiled
def _bounded_sum(first, second):  # type: ignore[no-untyped-def]
    """Add, up to 65535; the compiler turns this form into one instruction."""
    return np.uint16(first + min(second, np.uint16(np.uint16(65535) - first)))


@compiled
def _mean(value, old, factor):  # type: ignore[no-untyped-def]
    rest = np.uint16(np.uint16(65535) - factor)
    return np.uint16(_upper(value, rest) + _upper(old, factor) + 1)


@compiled
def _change_of_row(now, numbers, line, values, squares):  # type: ignore[no-untyped-def]
    gain, less, half, shift, most = numbers[0], numbers[1], numbers[2], numbers[3] & 15, np.uint16(255)
    for x in range(now.size):
        value = np.uint16(np.uint16(now[x]) * gain)
        value = np.uint16(max(value, less) - less)
        values[x] = value
        difference = np.uint16(max(value, line[x]) - min(value, line[x]))
        change = min(np.uint16(_bounded_sum(difference, half) >> shift), most)
        squares[x + 1] = np.uint16(change * change)
    squares[0], squares[now.size + 1] = squares[1], squares[now.size]


@compiled
def _add_rows(first, second, third, columns):  # type: ignore[no-untyped-def]
    for x in range(columns.size):
        columns[x] = _bounded_sum(_bounded_sum(first[x], second[x]), third[x])


@compiled(fastmath=True)
def _row_weights(columns, rate, weights):  # type: ignore[no-untyped-def]
    """Compute the weights of a row; approximate reciprocals take a third of the time."""
    one, half, whole = np.float32(1), np.float32(0.5), np.float32(FULL_WEIGHT)
    for x in range(weights.size):
        change = _bounded_sum(_bounded_sum(columns[x], columns[x + 1]), columns[x + 2])
        ratio = np.float32(np.int32(change)) * rate
        weights[x] = np.uint8(np.int32(whole / (one + ratio * ratio) + half))


@compiled
def _set_factors(parts, guide, across, weight, factors):  # type: ignore[no-untyped-def]
    """Compute products of stored weights in 65536ths. LLVM vectorizes the loops with a fixed step."""
    if across == 1:
        for x in range(parts.size):
            factors[x] = np.uint16(_product(parts[x], guide[x]) * weight)
    elif across == 2:
        for x in range(parts.size):
            factors[x] = np.uint16(_product(parts[x], guide[2 * x]) * weight)
    else:
        for x in range(parts.size):
            factors[x] = np.uint16(_product(parts[x], guide[x * across]) * weight)


@compiled
def _product(first, second):  # type: ignore[no-untyped-def]
    return np.uint16(np.uint16(np.uint16(first) * np.uint16(second) + np.uint16(FULL_WEIGHT)) >> 8)


@compiled
def _blend_row(values, line, factors, out):  # type: ignore[no-untyped-def]
    for x in range(out.size):
        out[x] = _mean(values[x], line[x], factors[x])


@compiled
def _blend_result(now, numbers, line, factors, out, codes):  # type: ignore[no-untyped-def]
    gain, half, shift = numbers[0], numbers[1], numbers[2] & 15
    for x in range(out.size):
        value = _mean(np.uint16(np.uint16(now[x]) * gain), line[x], factors[x])
        out[x] = value
        codes[x] = np.uint16(_bounded_sum(value, half) >> shift)
