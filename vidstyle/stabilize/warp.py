"""A row of a plane, moved along the flow: each sample from where it was in the plane before."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled


@compiled
def move_row(before, y, flow, wide, held, line):  # type: ignore[no-untyped-def]
    """Fill row `y` of a plane with what lay there before.

    Flow is first brought to all columns, a row of its grid at a time: it is the same for several rows of the
    plane, so that little more than a mean of two is left to do for each sample.

    Args:
        before: H x W.
        flow: on a coarse grid over the plane, h x w x 2 float32, in samples.
        wide, held: two rows of it, 2 x 2 x W float32, and which they are; -1 is none, and what stands still
            is kept as -2 and less. To be given again for the next row.
        line: the row, W float32.
    """
    rows, height = flow.shape[0], before.shape[0]
    place = (np.float32(y) + np.float32(0.5)) * np.float32(rows) / np.float32(height) - np.float32(0.5)
    upper = int(np.floor(place))
    above, below = min(max(upper, 0), rows - 1), min(max(upper + 1, 0), rows - 1)
    for row in (above, below):
        if held[row % 2] not in (row, -2 - row):
            held[row % 2] = row if _widen_row(flow[row], wide[row % 2]) else -2 - row
    if held[above % 2] >= 0 or held[below % 2] >= 0:
        _take_row(before, y, wide[above % 2], wide[below % 2], place - np.float32(upper), line)
    else:
        for x in range(line.size):
            line[x] = before[y, x]


@compiled
def _widen_row(flow, wide):  # type: ignore[no-untyped-def]
    """A row of the flow's grid, w x 2, to all columns, 2 x width; returns whether anything moves in it."""
    columns, width = flow.shape[0], wide.shape[1]
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
                wide[axis, x] = flow[left, axis] + part * (flow[right, axis] - flow[left, axis])
    else:
        wide[:] = 0
    return moves


@compiled(fastmath=True)
def _take_row(before, y, above, below, part, line):  # type: ignore[no-untyped-def]
    """Each sample of a row from where it was, linear between samples; the border is repeated.

    First where from, then what lies there: the first loop becomes vectors, which the second cannot.
    """
    height, width = before.shape
    zero, bottom, right = np.float32(0), np.float32(height - 1), np.float32(width - 1)
    last_row, last_column = np.int32(max(height - 2, 0)), np.int32(max(width - 2, 0))
    first = np.empty(width, np.uint32)
    parts = np.empty((2, width), np.float32)
    across, more_across = above[0], below[0]
    down, more_down = above[1], below[1]
    for x in range(width):
        from_x = np.float32(np.int32(x)) + across[x] + part * (more_across[x] - across[x])
        from_y = np.float32(y) + down[x] + part * (more_down[x] - down[x])
        from_x, from_y = min(max(from_x, zero), right), min(max(from_y, zero), bottom)
        column, row = min(np.int32(from_x), last_column), min(np.int32(from_y), last_row)
        parts[0, x], parts[1, x] = from_x - np.float32(column), from_y - np.float32(row)
        # Unsigned, so that no index is looked at for being negative.
        first[x] = np.uint32(row) * np.uint32(width) + np.uint32(column)
    samples = before.reshape(-1)
    beside, under = np.uint32(width > 1), np.uint32(width if height > 1 else 0)
    for x in range(width):
        here, lower = first[x], np.uint32(first[x] + under)
        upper_left, lower_left = np.float32(samples[here]), np.float32(samples[lower])
        upper = upper_left + parts[0, x] * (np.float32(samples[np.uint32(here + beside)]) - upper_left)
        low = lower_left + parts[0, x] * (np.float32(samples[np.uint32(lower + beside)]) - lower_left)
        line[x] = upper + parts[1, x] * (low - upper)
