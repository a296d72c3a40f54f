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

    def run(top: int, bottom: int) -> None:
        scratch = np.empty((5, plane.shape[1]), np.float32), np.zeros((3, plane.shape[1] + 2), np.float32)
        _source_rows(
            plane,
            before,
            before.reshape(-1),
            flow,
            guide,
            step,
            numbers,
            (top, bottom),
            scratch,
            weights,
            out,
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

    def run(top: int, bottom: int) -> None:
        scratch = np.empty((2, plane.shape[1]), np.float32)
        _result_rows(
            plane, before, before.reshape(-1), flow, segment_weights, guide, step, numbers, (top, bottom),
            scratch, out, codes,
        )  # fmt: skip

    return run


_NO_GUIDE = np.zeros((1, 1), np.uint8)


@compiled
def _source_rows(plane, before, samples, flow, guide, step, numbers, rows, scratch, weights, out):  # type: ignore[no-untyped-def]
    across, down = step
    gain, offset, weight, rate, rounding = numbers
    lines, changes = scratch
    (top, bottom), height = rows, plane.shape[0]
    for row in range(top - 1, bottom + 1):
        y = min(max(row, 0), height - 1)
        line = lines[row % 3]
        _warp_row(before, samples, y, flow, line)
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
def _result_rows(plane, before, samples, flow, parts, guide, step, numbers, rows, scratch, out, codes):  # type: ignore[no-untyped-def]
    across, down = step
    gain, weight, rounding, back, most = numbers
    line, weights = scratch[0], scratch[1]
    for row in range(rows[0], rows[1]):
        _warp_row(before, samples, row, flow, line)
        of_row = parts[_grid_row(row, plane.shape[0], parts.shape[0])]
        _guide_row(guide[row * down], across, weight, weights)
        if parts.shape[0] > 1:
            for x in range(weights.size):
                weights[x] *= of_row[x // SEGMENT, 0]
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
    first, second, third = changes[0], changes[1], changes[2]
    for x in range(weights.size):
        total = first[x] + first[x + 1] + first[x + 2]
        total += second[x] + second[x + 1] + second[x + 2]
        total += third[x] + third[x + 1] + third[x + 2]
        ratio = total * rate
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


@compiled
def _warp_row(before, samples, y, flow, line):  # type: ignore[no-untyped-def]
    """Fill a line with row `y` of a plane as the plane before shows it, linear between samples.

    Args:
        before, samples: H x W, and the same as one row.
        flow: see `source_rows`.
        line: W float32.
    """
    row = flow[_grid_row(y, before.shape[0], flow.shape[0])]
    moves = False
    for segment in range(row.shape[0]):
        moves |= row[segment, 0] != 0 or row[segment, 1] != 0
    if moves:
        for segment in range(row.shape[0]):
            _warp_segment(before, samples, y, segment * SEGMENT, row[segment, 0], row[segment, 1], line)
    else:
        for x in range(line.size):
            line[x] = before[y, x]


@compiled
def _warp_segment(before, samples, y, start, across, down, line):  # type: ignore[no-untyped-def]
    height, width = before.shape
    one = np.float32(1)
    right, under = int(np.floor(across)), int(np.floor(down))
    x_part, y_part = across - np.float32(right), down - np.float32(under)
    weights = (
        (one - x_part) * (one - y_part),
        x_part * (one - y_part),
        (one - x_part) * y_part,
        x_part * y_part,
    )
    left, top = start + right, y + under
    if 0 <= left and left + SEGMENT < width and 0 <= top and top + 1 < height and start + SEGMENT <= width:
        first = top * width + left
        take_segment(samples, first, first + width, weights, line, start)
    else:
        last_column, last_row = width - 1, height - 1
        upper, lower = index_at(top, last_row), index_at(top + 1, last_row)
        for x in range(start, min(start + SEGMENT, width)):
            here, beside = index_at(x + right, last_column), index_at(x + right + 1, last_column)
            high = weights[0] * np.float32(before[upper, here]) + weights[1] * np.float32(
                before[upper, beside]
            )
            low = weights[2] * np.float32(before[lower, here]) + weights[3] * np.float32(
                before[lower, beside]
            )
            line[x] = high + low
