"""Blends a plane of a frame with that of the previous frame, warped along the motion."""

from __future__ import annotations

from concurrent.futures import Executor

import numpy as np

from vidstyle.core.bands import in_bands
from vidstyle.core.kernels import compiled, index_at

STILL = np.zeros((1, 1, 2), np.float32)
"""The flow of a film in which nothing moves."""
BAND_RADIUS = 8
"""As the radius for `in_bands`: bands are much higher than the row that is read beside them, so that few rows
are computed twice."""


def warp_and_blend(
    pool: Executor,
    plane: np.ndarray,
    scale: tuple[float, float],
    before: np.ndarray,
    flow: np.ndarray | None,
    weight: float,
    *,
    limit: float = np.inf,
    guide: np.ndarray | None = None,
    step: tuple[int, int] = (1, 1),
) -> tuple[np.ndarray, np.ndarray]:
    """Warp the previous plane and blend it into this one.

    Change is the root mean square difference over 3 x 3 samples. With r = (change / limit)^2, the weight of
    the previous plane is weight * guide / (1 + r^2).

    Args:
        plane: H x W, of any type.
        scale: gain and offset that bring its codes to units of the result.
        before: the result of this function for the previous frame, float32 or uint16, contiguous.
        flow: see `Warp`, in luma pixels.
        weight: of the previous plane, 0..1.
        limit: change that halves the weight, in units of the result; infinite: change is ignored.
        guide: the weights of the luma plane, H x W float32; None: 1.
        step: luma pixels for each sample of this plane, across and down.

    Returns:
        The new plane, of the type of `before`, and the weights as parts of `weight`, H x W float32, 0..1.
    """
    out, samples = np.empty(plane.shape, before.dtype), before.reshape(-1)
    weights = np.empty(plane.shape, np.float32)
    flow = STILL if flow is None else flow / np.array(step, np.float32)
    guide = np.ones((1, 1), np.float32) if guide is None else guide
    rate = 0 if np.isinf(limit) else 1 / (9 * limit**2)
    rounding = 0.5 if out.dtype == np.uint16 else 0
    numbers = tuple(np.float32(number) for number in (*scale, weight, rate, rounding))

    def run(top: int, bottom: int) -> None:
        rows = (top, bottom), _scratch(plane.shape[1])
        _warp_and_blend(plane, before, samples, flow, guide, step, numbers, *rows, weights, out)

    in_bands(pool, (plane.shape[0], plane.shape[1]), BAND_RADIUS, run)
    return out, weights


def _scratch(width: int) -> tuple[np.ndarray, ...]:
    """What is kept between the rows of a band, and between the loops over a row.

    Rings of three rows, the warped plane before and the squared change of each sample; `widened` and
    `widened_rows` of `_warp_row`; the index and the two parts of `_take_row`.
    """
    return (
        np.empty((3, width), np.float32),
        np.zeros((3, width + 2), np.float32),
        np.empty((2, 2, width), np.float32),
        np.full(2, -1, np.int32),
        np.empty(width, np.uint32),
        np.empty((2, width), np.float32),
    )


@compiled
def _warp_and_blend(plane, before, samples, flow, guide, step, numbers, rows, scratch, weights, out):  # type: ignore[no-untyped-def]
    across, down = step
    gain, offset, weight, rate, rounding = numbers
    moved, changes, widened, widened_rows, first, parts = scratch
    (top, bottom), height = rows, plane.shape[0]
    for row in range(top - 1, bottom + 1):
        y = min(max(row, 0), height - 1)
        line, change = moved[row % 3], changes[row % 3]
        _warp_row(before, samples, y, flow, widened, widened_rows, first, parts, line)
        if rate > 0:
            _change_of_row(plane[y], gain, offset, line, change)
        if row > top:
            done = row - 1
            _row_weights(changes, rate, guide[min(done * down, guide.shape[0] - 1)], across, weights[done])
            _blend_row(plane[done], gain, offset, moved[done % 3], weight, weights[done], rounding, out[done])


@compiled
def _change_of_row(now, gain, offset, line, change):  # type: ignore[no-untyped-def]
    for x in range(line.size):
        difference = now[x] * gain + offset - line[x]
        change[x + 1] = difference * difference
    change[0], change[line.size + 1] = change[1], change[line.size]


@compiled
def _row_weights(changes, rate, guide, across, weights):  # type: ignore[no-untyped-def]
    one = np.float32(1)
    if rate > 0:
        first, second, third = changes[0], changes[1], changes[2]
        for x in range(weights.size):
            total = first[x] + first[x + 1] + first[x + 2]
            total += second[x] + second[x + 1] + second[x + 2]
            total += third[x] + third[x + 1] + third[x + 2]
            ratio = total * rate
            weights[x] = one / (one + ratio * ratio)
    else:
        for x in range(weights.size):
            weights[x] = one
    if guide.size > 1:
        for x in range(weights.size):
            weights[x] *= guide[min(x * across, guide.size - 1)]


@compiled
def _blend_row(now, gain, offset, line, weight, weights, rounding, out):  # type: ignore[no-untyped-def]
    most = np.float32(65535)
    for x in range(out.size):
        value = now[x] * gain + offset
        value += weight * weights[x] * (line[x] - value)
        out[x] = min(max(value + rounding, np.float32(0)), most) if rounding > 0 else value


@compiled
def _warp_row(before, samples, y, flow, widened, widened_rows, first, parts, line):  # type: ignore[no-untyped-def]
    """Fill row `y` of a plane with the warped plane before.

    Flow is first brought to all columns, a row of its grid at a time: it is the same for several rows of the
    plane, so that little more than a mean of two is left to do for each sample.

    Args:
        before, samples: H x W, and the same as one row.
        flow: on a coarse grid over the plane, h x w x 2 float32, in samples.
        widened, widened_rows: two of its rows at full width, 2 x 2 x W float32, and which they are: -1 for
            none, -2 - row for one without motion. The caller passes them again for the next row.
        first, parts: see `_take_row`.
        line: the row, W float32.
    """
    rows, height = flow.shape[0], before.shape[0]
    place = (np.float32(y) + np.float32(0.5)) * np.float32(rows) / np.float32(height) - np.float32(0.5)
    upper = int(np.floor(place))
    above, below = min(max(upper, 0), rows - 1), min(max(upper + 1, 0), rows - 1)
    for row in (above, below):
        if widened_rows[row % 2] not in (row, -2 - row):
            widened_rows[row % 2] = row if _widen_row(flow[row], widened[row % 2]) else -2 - row
    if widened_rows[above % 2] >= 0 or widened_rows[below % 2] >= 0:
        part = place - np.float32(upper)
        _take_row(before, samples, y, widened[above % 2], widened[below % 2], part, first, parts, line)
    else:
        for x in range(line.size):
            line[x] = before[y, x]


@compiled
def _widen_row(flow, widened):  # type: ignore[no-untyped-def]
    """Interpolate a row of the flow's grid, w x 2, to 2 x width; return whether anything moves in it."""
    columns, width = flow.shape[0], widened.shape[1]
    moves = False
    for column in range(columns):
        moves = moves or flow[column, 0] != 0 or flow[column, 1] != 0
    if moves:
        each, half = np.float32(columns) / np.float32(width), np.float32(0.5)
        for x in range(width):
            place = (np.float32(x) + half) * each - half
            before = np.floor(place)
            part = place - before
            left, right = max(int(before), 0), min(int(before) + 1, columns - 1)
            for axis in range(2):
                widened[axis, x] = flow[left, axis] + part * (flow[right, axis] - flow[left, axis])
    else:
        for x in range(width):
            widened[0, x], widened[1, x] = 0, 0
    return moves


@compiled(fastmath=True)
def _take_row(before, samples, y, above, below, part, first, parts, line):  # type: ignore[no-untyped-def]
    """Read a row at its flow, linear between samples; the border is repeated.

    First where from, the index of a sample and the parts of the next ones, then what lies there: the first
    loop becomes vectors, which the second cannot.
    """
    height, width = before.shape
    zero, bottom, right = np.float32(0), np.float32(height - 1), np.float32(width - 1)
    last_row, last_column = np.int32(max(height - 2, 0)), np.int32(max(width - 2, 0))
    across, more_across = above[0], below[0]
    down, more_down = above[1], below[1]
    for x in range(width):
        from_x = np.float32(np.int32(x)) + across[x] + part * (more_across[x] - across[x])
        from_y = np.float32(y) + down[x] + part * (more_down[x] - down[x])
        from_x, from_y = min(max(from_x, zero), right), min(max(from_y, zero), bottom)
        column, row = index_at(from_x, last_column), index_at(from_y, last_row)
        parts[0, x], parts[1, x] = from_x - np.float32(column), from_y - np.float32(row)
        # Unsigned, so that no index is looked at for being negative.
        first[x] = np.uint32(row) * np.uint32(width) + np.uint32(column)
    beside, under = np.uint32(width > 1), np.uint32(width if height > 1 else 0)
    for x in range(width):
        here, lower = first[x], np.uint32(first[x] + under)
        upper_left, lower_left = np.float32(samples[here]), np.float32(samples[lower])
        upper = upper_left + parts[0, x] * (np.float32(samples[np.uint32(here + beside)]) - upper_left)
        low = lower_left + parts[0, x] * (np.float32(samples[np.uint32(lower + beside)]) - lower_left)
        line[x] = upper + parts[1, x] * (low - upper)
