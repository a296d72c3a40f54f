"""Kernels that blend planes of floats."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.stabilize.blend_codes import WHOLE
from vidstyle.stabilize.segment import SEGMENT
from vidstyle.stabilize.warp import grid_row, warp_row

_ONE = np.float32(1)
_PART = np.float32(1 / WHOLE)


@compiled
def source_float_rows(plane, before, samples, moves, guide, step, numbers, rows, scratch, weights, out):  # type: ignore[no-untyped-def]
    """See `blend.source_rows`.

    Args:
        numbers: gain and offset from codes, weight of the previous plane, and 1 / (9 limit^2).
    """
    across, down = step
    gain, offset, weight, rate = numbers
    lines, changes, beside = scratch
    (top, bottom), height = rows, plane.shape[0]
    for row in range(top - 1, bottom + 1):
        y = min(max(row, 0), height - 1)
        line = lines[row % 2]
        warp_row(before, samples, y, moves, beside, line)
        _change_of_row(plane[y], gain, offset, line, changes[row % 3])
        if row > top:
            done = row - 1
            stored, old = weights[done % weights.shape[0]], lines[done % 2]
            _row_weights(changes, rate, stored)
            _set_weights(stored, 1, weight, lines[2])
            if guide.size > 1:
                _set_weights(guide[done * down], across, _ONE, lines[3])
                for x in range(plane.shape[1]):
                    lines[2, x] *= lines[3, x]
            for x in range(plane.shape[1]):
                value = np.float32(plane[done, x]) * gain + offset
                out[done, x] = value + lines[2, x] * (old[x] - value)


@compiled
def result_float_rows(plane, before, samples, moves, parts, guide, step, rows, scratch, out):  # type: ignore[no-untyped-def]
    """See `blend.result_rows`.

    Args:
        parts: weight of the previous plane in segments, h x w float32.
    """
    across, down = step
    lines, beside = scratch
    line, weights = lines[0], lines[1]
    for row in range(rows[0], rows[1]):
        warp_row(before, samples, row, moves, beside, line)
        _set_weights(guide[row * down], across, _ONE, weights)
        place = grid_row(row, plane.shape[0], parts.shape[0])
        for x in range(plane.shape[1]):
            value = plane[row, x]
            out[row, x] = value + parts[place, x // SEGMENT] * weights[x] * (line[x] - value)


@compiled
def _change_of_row(now, gain, offset, line, change):  # type: ignore[no-untyped-def]
    for x in range(now.size):
        difference = np.float32(now[x]) * gain + offset - line[x]
        change[x + 1] = difference * difference
    change[0], change[now.size + 1] = change[1], change[now.size]


@compiled
def _row_weights(changes, rate, weights):  # type: ignore[no-untyped-def]
    one, whole, half = np.float32(1), np.float32(WHOLE), np.float32(0.5)
    first, second, third, columns = changes[0], changes[1], changes[2], changes[3]
    for x in range(weights.size + 2):
        columns[x] = first[x] + second[x] + third[x]
    for x in range(weights.size):
        ratio = (columns[x] + columns[x + 1] + columns[x + 2]) * rate
        weights[x] = np.uint8(whole / (one + ratio * ratio) + half)


@compiled
def _set_weights(stored, across, weight, weights):  # type: ignore[no-untyped-def]
    part = weight * _PART
    for x in range((stored.size + across - 1) // across):
        weights[x] = np.float32(stored[x * across]) * part
