"""Kernels that blend float planes."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.stabilize.blend_codes import FULL_WEIGHT
from vidstyle.stabilize.segment import SEGMENT_SIZE
from vidstyle.stabilize.warp import LINE_COUNT, grid_row, has_moved, warp_group

_UNIT_WEIGHT = np.float32(1)
_CODE_WEIGHT = np.float32(1 / FULL_WEIGHT)


@compiled
def source_float_rows(plane, before, samples, moves, guide, step, numbers, rows, scratch, weights, out):  # type: ignore[no-untyped-def]
    """See `blend.source_rows`.

    Args:
        numbers: gain and offset from codes, weight of the previous plane, and 1 / (9 limit^2).
    """
    across, down = step
    gain, offset, weight, rate = numbers
    lines, (changes, columns), (own, other), beside = scratch
    (top, bottom), last = rows, plane.shape[0] - 1
    warped = compared = max(top - 1, 0)
    for y in range(top, bottom):
        while compared <= min(y + 1, last):
            if compared == warped:
                warped = warp_group(before, samples, warped, min(bottom, last) + 1, moves, beside, lines)
            old = lines[compared % LINE_COUNT] if has_moved(compared, last + 1, moves) else before[compared]
            _change_of_row(plane[compared], gain, offset, old, changes[compared % 3])
            compared += 1
        _add_rows(changes[max(y - 1, 0) % 3], changes[y % 3], changes[min(y + 1, last) % 3], columns)
        old = lines[y % LINE_COUNT] if has_moved(y, last + 1, moves) else before[y]
        stored = weights[y % weights.shape[0]]
        _row_weights(columns, rate, stored)
        _set_weights(stored, 1, weight, own)
        if guide.size > 1:
            _set_weights(guide[y * down], across, _UNIT_WEIGHT, other)
            for x in range(plane.shape[1]):
                own[x] *= other[x]
        for x in range(plane.shape[1]):
            value = np.float32(plane[y, x]) * gain + offset
            out[y, x] = value + own[x] * (old[x] - value)


@compiled
def result_float_rows(plane, before, samples, moves, parts, guide, step, rows, scratch, out):  # type: ignore[no-untyped-def]
    """See `blend.result_rows`.

    Args:
        parts: weight of the previous plane in segments, h x w float32.
    """
    across, down = step
    (lines, weights, beside), warped = scratch, rows[0]
    for y in range(rows[0], rows[1]):
        if y == warped:
            warped = warp_group(before, samples, y, rows[1], moves, beside, lines)
        _set_weights(guide[y * down], across, _UNIT_WEIGHT, weights)
        place = grid_row(y, plane.shape[0], parts.shape[0])
        old = lines[y % LINE_COUNT] if has_moved(y, plane.shape[0], moves) else before[y]
        for x in range(plane.shape[1]):
            value = plane[y, x]
            out[y, x] = value + parts[place, x // SEGMENT_SIZE] * weights[x] * (old[x] - value)


@compiled
def _change_of_row(now, gain, offset, line, change):  # type: ignore[no-untyped-def]
    for x in range(now.size):
        difference = np.float32(now[x]) * gain + offset - line[x]
        change[x + 1] = difference * difference
    change[0], change[now.size + 1] = change[1], change[now.size]


@compiled
def _add_rows(first, second, third, columns):  # type: ignore[no-untyped-def]
    for x in range(columns.size):
        columns[x] = first[x] + second[x] + third[x]


@compiled
def _row_weights(columns, rate, weights):  # type: ignore[no-untyped-def]
    one, whole, half = np.float32(1), np.float32(FULL_WEIGHT), np.float32(0.5)
    for x in range(weights.size):
        ratio = (columns[x] + columns[x + 1] + columns[x + 2]) * rate
        weights[x] = np.uint8(whole / (one + ratio * ratio) + half)


@compiled
def _set_weights(stored, across, weight, weights):  # type: ignore[no-untyped-def]
    part = weight * _CODE_WEIGHT
    for x in range((stored.size + across - 1) // across):
        weights[x] = np.float32(stored[x * across]) * part
