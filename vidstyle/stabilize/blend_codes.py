"""Kernels that blend planes of 16 bits, in sums and products of 16 bits: twice as many at once as of floats.

A product is the upper half of 32 bits, rounded down. Where two of them make a value, 1 is added, so that what
is blended again and again does not darken.
"""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.stabilize.segment import SEGMENT
from vidstyle.stabilize.warp import grid_row, warp_row

WHOLE = 255
"""The weight 1 as it is stored."""
LIMIT_STEPS = 17
"""Most steps of change up to the limit: the sum of nine squares has room until the weight is 0."""


@compiled
def source_code_rows(plane, before, samples, moves, guide, step, numbers, rows, scratch, weights, out):  # type: ignore[no-untyped-def]
    """See `blend.source_rows`.

    Args:
        numbers: uint16: gain from codes to those of 16 bits, and what is taken off then; half a step of
            change, and the step's logarithm to the base 2; weight of the previous plane, 1 as 257. And
            float32: 1 / (9 limit^2), the limit in steps.
    """
    across, down = step
    codes, rate = numbers
    lines, squares, stored, ones, beside = scratch
    factors, (top, bottom), height = lines[4], rows, plane.shape[0]
    for row in range(top - 1, bottom + 1):
        y = min(max(row, 0), height - 1)
        line, values = lines[row % 2], lines[2 + row % 2]
        warp_row(before, samples, y, moves, beside, line)
        _change_of_row(plane[y], codes, line, values, squares[row % 3])
        if row > top:
            done = row - 1
            if guide.size > 1:
                _row_weights(squares, rate, stored)
                _set_factors(stored, guide[done * down], across, codes[4], factors)
            else:
                _row_weights(squares, rate, weights[done])
                _set_factors(ones, weights[done], 1, codes[4], factors)
            _blend_row(lines[2 + done % 2], lines[done % 2], factors, out[done])


@compiled
def result_code_rows(plane, before, samples, moves, parts, guide, step, numbers, rows, scratch, out, codes):  # type: ignore[no-untyped-def]
    """See `blend.result_rows`.

    Args:
        parts: weights of segments as stored, h x w.
        numbers: uint16: gain from codes to those of 16 bits, half of it, and its logarithm to the base 2;
            weight of the previous plane, 1 as 257.
    """
    across, down = step
    (lines, of_row, beside), filled = scratch, -1
    line, factors = lines[0], lines[1]
    for row in range(rows[0], rows[1]):
        warp_row(before, samples, row, moves, beside, line)
        place = grid_row(row, plane.shape[0], parts.shape[0])
        if place != filled:
            for x in range(of_row.size):
                of_row[x] = parts[place, x // SEGMENT]
            filled = place
        _set_factors(of_row, guide[row * down], across, numbers[3], factors)
        _blend_result(plane[row], numbers, line, factors, out[row], codes[row])


@compiled
def _upper(first, second):  # type: ignore[no-untyped-def]
    return np.uint16(np.uint32(np.uint32(first) * np.uint32(second)) >> np.uint32(16))


@compiled
def _bounded_sum(first, second):  # type: ignore[no-untyped-def]
    """At most 65535; the compiler knows this form as one instruction."""
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


@compiled(fastmath=True)
def _row_weights(squares, rate, weights):  # type: ignore[no-untyped-def]
    """Reciprocals may be approximate, which takes a third of the time."""
    one, half, whole = np.float32(1), np.float32(0.5), np.float32(WHOLE)
    first, second, third, columns = squares[0], squares[1], squares[2], squares[3]
    for x in range(weights.size + 2):
        columns[x] = _bounded_sum(_bounded_sum(first[x], second[x]), third[x])
    for x in range(weights.size):
        change = _bounded_sum(_bounded_sum(columns[x], columns[x + 1]), columns[x + 2])
        ratio = np.float32(np.int32(change)) * rate
        weights[x] = np.uint8(np.int32(whole / (one + ratio * ratio) + half))


@compiled
def _set_factors(parts, guide, across, weight, factors):  # type: ignore[no-untyped-def]
    """Products of stored weights in 65536ths. LLVM makes vectors of the loops with a fixed step."""
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
    return np.uint16(np.uint16(np.uint16(first) * np.uint16(second) + np.uint16(WHOLE)) >> 8)


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
