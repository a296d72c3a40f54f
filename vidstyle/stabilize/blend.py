"""Blends a plane of a frame with that of the previous frame, warped along the motion."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from vidstyle.core.kernels import compiled, index_at
from vidstyle.stabilize.segment import SEGMENT, take_segment

Rows = Callable[[int, int], None]
"""Computes the rows from the first number to before the second."""

STILL = np.zeros((1, 1, 2), np.float32)
"""The flow of a film in which nothing moves."""
WHOLE = 255
"""The weight 1 as it is stored."""


def in_segments(grid: np.ndarray | None, width: int) -> np.ndarray:
    """A grid over the page, interpolated at the middle of each `SEGMENT` samples of a plane's row.

    Those samples are moved and weighted alike, so that they can be read side by side.

    Args:
        grid: h x w x n float32; None for a flow of 0.
        width: of the plane.

    Returns:
        h x ceil(width / `SEGMENT`) x n float32, contiguous.
    """
    grid = STILL if grid is None else grid
    out = np.empty((grid.shape[0], -(-width // SEGMENT), grid.shape[2]), np.float32)
    _in_segments(grid, width, out)
    return out


def source_rows(
    plane: np.ndarray,
    scale: tuple[float, float],
    before: np.ndarray,
    flow: np.ndarray,
    weight: float,
    limit: float,
    guide: np.ndarray | None,
    step: tuple[int, int],
    out: np.ndarray,
    weights: np.ndarray,
) -> Rows:
    """Warp the previous plane of the source and blend it into this one.

    Change is the root mean square difference over 3 x 3 samples. With r = (change / limit)^2, the weight of
    the previous plane is weight * guide / (1 + r^2).

    Args:
        plane: H x W, of any type.
        scale: gain and offset that bring its codes to units of the result.
        before: `out` for the previous frame, float32 or uint16, contiguous.
        flow: where each segment was, in samples of the plane to the right and down; see `in_segments`.
        weight: of the previous plane, 0..1.
        limit: change that halves the weight, in units of the result.
        guide: the weights of the luma plane, of whose rows this plane's are computed after; None: 1.
        step: luma pixels for each sample of this plane, across and down.
        out: takes the new plane.
        weights: takes the weights as parts of `weight`, H x W uint8, 1 as `WHOLE`.
    """
    guide = _NO_GUIDE if guide is None else guide
    rounding = 0.5 if out.dtype == np.uint16 else 0.0
    numbers = tuple(np.float32(number) for number in (*scale, weight / WHOLE, 1 / (9 * limit**2), rounding))
    samples, moves = before.reshape(-1), _moves(flow, plane.shape[1])

    def run(top: int, bottom: int) -> None:
        scratch = np.empty((5, plane.shape[1]), np.float32), np.zeros((4, plane.shape[1] + 2), np.float32)
        _source_rows(
            plane, before, samples, moves, guide, step, numbers, (top, bottom), scratch, weights, out
        )

    return run


def result_rows(
    plane: np.ndarray,
    gain: float,
    before: np.ndarray,
    flow: np.ndarray,
    segment_weights: np.ndarray,
    weight: float,
    guide: np.ndarray,
    step: tuple[int, int],
    out: np.ndarray,
    codes: np.ndarray,
) -> Rows:
    """Warp the previous plane of the result and blend it into this one, with the weights of the source.

    Args:
        plane, before, flow, weight, guide, step, out: see `source_rows`.
        gain: brings its codes to units of `out`.
        segment_weights: further weights of segments, h x w x 1.
        codes: takes the new plane in the codes of `plane`.
    """
    rounding, most = (0.0, 0.0) if codes.dtype == np.float32 else (0.5, 65535 / gain)
    numbers = tuple(np.float32(number) for number in (gain, weight / WHOLE, rounding, 1 / gain, most))
    samples, moves = before.reshape(-1), _moves(flow, plane.shape[1])

    def run(top: int, bottom: int) -> None:
        scratch = np.ones((3, plane.shape[1]), np.float32)
        _result_rows(
            plane, before, samples, moves, segment_weights, guide, step, numbers, (top, bottom), scratch,
            out, codes,
        )  # fmt: skip

    return run


_NO_GUIDE = np.zeros((1, 1), np.uint8)


@compiled
def _source_rows(plane, before, samples, moves, guide, step, numbers, rows, scratch, weights, out):  # type: ignore[no-untyped-def]
    across, down = step
    gain, offset, weight, rate, rounding = numbers
    lines, changes = scratch
    (top, bottom), height = rows, plane.shape[0]
    for row in range(top - 1, bottom + 1):
        y = min(max(row, 0), height - 1)
        line = lines[row % 3]
        _warp_row(before, samples, y, moves, line)
        _change_of_row(plane[y], gain, offset, line, changes[row % 3])
        if row > top:
            done = row - 1
            _row_weights(changes, rate, lines[4])
            if guide.size > 1:
                _guide_row(guide[done * down], across, np.float32(1 / WHOLE), lines[3])
                for x in range(lines.shape[1]):
                    lines[4, x] *= lines[3, x]
            blended = plane[done], gain, offset, lines[done % 3]
            _blend_row(blended, weight, lines[4], rounding, weights[done], out[done])


@compiled
def _result_rows(plane, before, samples, moves, parts, guide, step, numbers, rows, scratch, out, codes):  # type: ignore[no-untyped-def]
    across, down = step
    gain, weight, rounding, back, most = numbers
    line, weights, of_row, filled = scratch[0], scratch[1], scratch[2], -1
    for row in range(rows[0], rows[1]):
        _warp_row(before, samples, row, moves, line)
        _guide_row(guide[row * down], across, weight, weights)
        if parts.shape[0] > 1:
            grid_row = _grid_row(row, plane.shape[0], parts.shape[0])
            if grid_row != filled:
                for x in range(of_row.size):
                    of_row[x] = parts[grid_row, x // SEGMENT, 0]
                filled = grid_row
            for x in range(weights.size):
                weights[x] *= of_row[x]
        _blend_result(plane[row], gain, line, weights, rounding, back, most, out[row], codes[row])


@compiled
def _change_of_row(now, gain, offset, line, change):  # type: ignore[no-untyped-def]
    for x in range(line.size):
        difference = np.float32(now[x]) * gain + offset - line[x]
        change[x + 1] = difference * difference
    change[0], change[line.size + 1] = change[1], change[line.size]


@compiled
def _row_weights(changes, rate, weights):  # type: ignore[no-untyped-def]
    one, whole = np.float32(1), np.float32(WHOLE)
    first, second, third, columns = changes[0], changes[1], changes[2], changes[3]
    for x in range(columns.size):
        columns[x] = first[x] + second[x] + third[x]
    for x in range(weights.size):
        ratio = (columns[x] + columns[x + 1] + columns[x + 2]) * rate
        weights[x] = whole / (one + ratio * ratio)


@compiled
def _guide_row(guide, across, factor, weights):  # type: ignore[no-untyped-def]
    """Weights of luma at the samples of a plane. LLVM makes vectors of the loops with a fixed step."""
    if across == 1:
        for x in range(weights.size):
            weights[x] = np.float32(guide[x]) * factor
    elif across == 2:
        for x in range(weights.size):
            weights[x] = np.float32(guide[2 * x]) * factor
    else:
        for x in range(weights.size):
            weights[x] = np.float32(guide[x * across]) * factor


@compiled
def _blend_row(blended, weight, weights, rounding, stored, out):  # type: ignore[no-untyped-def]
    now, gain, offset, line = blended
    zero, most, half = np.float32(0), np.float32(65535), np.float32(0.5)
    for x in range(out.size):
        stored[x] = np.uint8(weights[x] + half)
        value = np.float32(now[x]) * gain + offset
        value += weight * weights[x] * (line[x] - value)
        out[x] = min(max(value + rounding, zero), most) if rounding > 0 else value


@compiled
def _blend_result(now, gain, line, weights, rounding, back, most, out, codes):  # type: ignore[no-untyped-def]
    zero, full, lift = np.float32(0), np.float32(65535), np.float32(0.503)
    if rounding > 0:
        for x in range(out.size):
            value = np.float32(now[x]) * gain
            value += weights[x] * (line[x] - value)
            out[x] = min(max(value + rounding, zero), full)
            codes[x] = min(max(value * back + lift, zero), most)
    else:
        for x in range(out.size):
            value = np.float32(now[x]) * gain
            value += weights[x] * (line[x] - value)
            out[x] = value
            codes[x] = value


@compiled
def _grid_row(y, height, rows):  # type: ignore[no-untyped-def]
    """The row of a grid over the page in which a row of a plane lies."""
    return (2 * y + 1) * rows // (2 * height)


@compiled
def _in_segments(grid, width, out):  # type: ignore[no-untyped-def]
    half, last = np.float32(0.5), np.int32(grid.shape[1] - 1)
    each = np.float32(grid.shape[1]) / np.float32(width)
    for row in range(out.shape[0]):
        for segment in range(out.shape[1]):
            place = np.float32(segment * SEGMENT + SEGMENT // 2) * each - half
            before = np.floor(place)
            left, right = index_at(before, last), index_at(before + np.float32(1), last)
            for axis in range(out.shape[2]):
                difference = grid[row, right, axis] - grid[row, left, axis]
                out[row, segment, axis] = grid[row, left, axis] + (place - before) * difference


Moves = tuple[np.ndarray, np.ndarray, np.ndarray]
"""For each segment: int32, h x w x 3, whole samples to the right and down, and 1 where what is read lies
within the plane's columns, else 0; float32, h x w x 4, weights of a sample, of that right of it, and of the
two below; and uint8, h, 1 for a row of segments that has not
moved."""


def _moves(flow: np.ndarray, width: int) -> Moves:
    """What `_warp_row` needs of the flow of a plane's segments, computed once for all of its rows."""
    places, parts = np.empty((*flow.shape[:2], 3), np.int32), np.empty((*flow.shape[:2], 4), np.float32)
    _fill_moves(flow, width, places, parts)
    return places, parts, np.asarray(~flow.any((1, 2)), np.uint8)


@compiled
def _fill_moves(flow, width, places, parts):  # type: ignore[no-untyped-def]
    one = np.float32(1)
    for row in range(flow.shape[0]):
        for segment in range(flow.shape[1]):
            across, down = flow[row, segment, 0], flow[row, segment, 1]
            right, under = np.int32(np.floor(across)), np.int32(np.floor(down))
            x_part, y_part = across - np.float32(right), down - np.float32(under)
            first, last = segment * SEGMENT, segment * SEGMENT + SEGMENT
            places[row, segment, 0], places[row, segment, 1] = right, under
            places[row, segment, 2] = first + right >= 0 and last + right < width and last <= width
            parts[row, segment, 0] = (one - x_part) * (one - y_part)
            parts[row, segment, 1] = x_part * (one - y_part)
            parts[row, segment, 2] = (one - x_part) * y_part
            parts[row, segment, 3] = x_part * y_part


@compiled
def _warp_row(before, samples, y, moves, line):  # type: ignore[no-untyped-def]
    """Fill a line with row `y` of a plane as the plane before shows it, linear between samples.

    Args:
        before, samples: H x W, and the same as one row.
        moves: see `_moves`.
        line: W float32.
    """
    places, parts, still = moves
    row = _grid_row(y, before.shape[0], still.size)
    if still[row]:
        for x in range(line.size):
            line[x] = before[y, x]
    elif _warp_segments(before, samples, y, places[row], parts[row], line):
        for segment in range(places.shape[1]):
            if not _is_within(before, y, places[row, segment]):
                _warp_at_border(before, y, segment, places[row, segment], parts[row, segment], line)


@compiled
def _is_within(before, y, place):  # type: ignore[no-untyped-def]
    return place[2] and y + place[1] >= 0 and y + place[1] + 1 < before.shape[0]


@compiled
def _warp_segments(before, samples, y, places, parts, line):  # type: ignore[no-untyped-def]
    """Those that come from within the plane; returns how many do not.

    There is another loop for these: one with both needs more registers than there are.
    """
    width, left_out = before.shape[1], 0
    for segment in range(places.shape[0]):
        if _is_within(before, y, places[segment]):
            weights = parts[segment, 0], parts[segment, 1], parts[segment, 2], parts[segment, 3]
            first = (y + places[segment, 1]) * width + segment * SEGMENT + places[segment, 0]
            take_segment(samples, first, first + width, weights, line, segment * SEGMENT)
        else:
            left_out += 1
    return left_out


@compiled
def _warp_at_border(before, y, segment, place, parts, line):  # type: ignore[no-untyped-def]
    """A segment of which a part comes from outside the plane, whose border is repeated there."""
    last_row, last_column = before.shape[0] - 1, before.shape[1] - 1
    upper, lower = index_at(y + place[1], last_row), index_at(y + place[1] + 1, last_row)
    for x in range(segment * SEGMENT, min(segment * SEGMENT + SEGMENT, before.shape[1])):
        here, beside = index_at(x + place[0], last_column), index_at(x + place[0] + 1, last_column)
        high = parts[0] * np.float32(before[upper, here]) + parts[1] * np.float32(before[upper, beside])
        low = parts[2] * np.float32(before[lower, here]) + parts[3] * np.float32(before[lower, beside])
        line[x] = high + low
