"""Rows of a plane, predicted from the previous plane by warping it along the motion."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled, index_at
from vidstyle.stabilize.segment import GROUP_ROWS, SEGMENT_SIZE, take_segment, take_segments

NO_MOTION = np.zeros((1, 1, 2), np.float32)
"""The flow of a film without motion."""
FULL_WEIGHT_SUM = 65535
"""Sum of the weights of four samples in `Moves` for 16-bit planes."""

LINE_COUNT = 2 * GROUP_ROWS
"""Number of lines in the ring buffer of warped rows: for one group, and the previous one."""

Moves = tuple[np.ndarray, np.ndarray, np.ndarray]
"""For each segment: int32, h x w x 2, whole samples to the right and down; h x w x 4, weights of a sample,
its right neighbour and the two samples below, float32, or uint16 with the sum `FULL_WEIGHT_SUM`. For each row
of segments: int32, h x 3, 1 if it has not moved, and the first and the end of the segments within the plane's
columns."""


def in_segments(grid: np.ndarray | None, width: int, step: tuple[int, int] = (1, 1)) -> np.ndarray:
    """Interpolate a grid over the page at the middle of each `SEGMENT_SIZE` samples of a plane's row.

    These samples have the same displacement and weight, so that they can be read together.

    Args:
        grid: h x w x n float32; None for a flow of 0.
        width: width of the plane.
        step: luma pixels per sample, across and down, by which a flow is divided.

    Returns:
        h x ceil(width / `SEGMENT_SIZE`) x n float32, contiguous.
    """
    grid = NO_MOTION if grid is None else grid
    out = _empty_segments(grid, width)
    _in_segments(grid, width, step, out)
    return out


def moves_of(flow: np.ndarray | None, width: int, step: tuple[int, int], dtype: np.dtype) -> Moves:
    """Convert the flow of a `Warp` for `warp_group`, once for all rows of a plane.

    Args:
        flow, width, step: see `in_segments`.
        dtype: type of the plane's samples, uint16 or float32.
    """
    flow = NO_MOTION if flow is None else flow
    segments, whole = _empty_segments(flow, width), 1 if dtype == np.float32 else FULL_WEIGHT_SUM
    moves = np.empty(segments.shape, np.int32), np.empty((*segments.shape[:2], 4), dtype)
    rows = np.empty((len(flow), 3), np.int32)
    _find_moves(flow, width, step, np.float32(whole), segments, *moves, rows)
    return *moves, rows


def _empty_segments(grid: np.ndarray, width: int) -> np.ndarray:
    return np.empty((grid.shape[0], -(-width // SEGMENT_SIZE), grid.shape[2]), np.float32)


@compiled
def warp_group(before, samples, y, bottom, moves, beside, lines):  # type: ignore[no-untyped-def]
    """Fill lines with warped rows of the previous plane, interpolated linearly between samples.

    Args:
        before, samples: H x W, and the same as one row; uint16 or float32.
        y: the first row.
        bottom: the row to stop before, at the latest.
        moves: see `moves_of`.
        beside: 4 x `SEGMENT_SIZE`, of the same type; scratch.
        lines: `LINE_COUNT` x whole segments, of the same type; row y is written to line y % `LINE_COUNT` if
            it `has_moved`.

    Returns:
        The row after the last warped row.
    """
    places, parts, rows = moves
    row, height = grid_row(y, before.shape[0], rows.shape[0]), before.shape[0]
    end = y + 1
    while end % GROUP_ROWS and end < bottom and grid_row(end, height, rows.shape[0]) == row:
        end += 1
    if not rows[row, 0]:
        _warp_alike(before, samples, (y, end), places[row], parts[row], rows[row], beside, lines)
    return end


@compiled
def has_moved(y, height, moves):  # type: ignore[no-untyped-def]
    """Whether `warp_group` writes a row to its line; otherwise it equals the row of the previous plane."""
    rows = moves[2]
    return rows[grid_row(y, height, rows.shape[0]), 0] == 0


@compiled
def grid_row(y, height, rows):  # type: ignore[no-untyped-def]
    """Return the row of a grid over the page that contains a row of a plane."""
    return (2 * y + 1) * rows // (2 * height)


@compiled
def _find_moves(flow, width, step, whole, segments, places, parts, rows):  # type: ignore[no-untyped-def]
    _in_segments(flow, width, step, segments)
    _fill_moves(segments, width, whole, places, parts, rows)


@compiled
def _in_segments(grid, width, step, out):  # type: ignore[no-untyped-def]
    half, last = np.float32(0.5), np.int32(grid.shape[1] - 1)
    each = np.float32(grid.shape[1]) / np.float32(width)
    for segment in range(out.shape[1]):
        place = np.float32(segment * SEGMENT_SIZE + SEGMENT_SIZE // 2) * each - half
        before = np.floor(place)
        left, right = index_at(before, last), index_at(before + np.float32(1), last)
        for row in range(out.shape[0]):
            for axis in range(out.shape[2]):
                difference = grid[row, right, axis] - grid[row, left, axis]
                value = grid[row, left, axis] + (place - before) * difference
                out[row, segment, axis] = value / np.float32(step[axis])


@compiled
def _fill_moves(flow, width, whole, places, parts, rows):  # type: ignore[no-untyped-def]
    one, half = np.float32(1), np.float32(0.5 if whole > 1 else 0)
    for row in range(flow.shape[0]):
        rows[row, 0], rows[row, 1], rows[row, 2] = 1, 0, flow.shape[1]
        for segment in range(flow.shape[1]):
            across, down = flow[row, segment, 0], flow[row, segment, 1]
            right, under = np.int32(np.floor(across)), np.int32(np.floor(down))
            x_part, y_part = across - np.float32(right), down - np.float32(under)
            places[row, segment, 0], places[row, segment, 1] = right, under
            parts[row, segment, 1] = whole * x_part * (one - y_part) + half
            parts[row, segment, 2] = whole * (one - x_part) * y_part + half
            parts[row, segment, 3] = whole * x_part * y_part + half
            others = np.float32(parts[row, segment, 1]) + np.float32(parts[row, segment, 2])
            others += np.float32(parts[row, segment, 3])
            parts[row, segment, 0] = max(whole - others, np.float32(0))
            if across != 0 or down != 0:
                rows[row, 0] = 0
            first, end = segment * SEGMENT_SIZE, segment * SEGMENT_SIZE + SEGMENT_SIZE
            if first + right < 0:
                rows[row, 1] = segment + 1
            if (end + right >= width or end > width) and segment < rows[row, 2]:
                rows[row, 2] = segment


@compiled
def _warp_alike(before, samples, span, places, parts, columns, beside, lines):  # type: ignore[no-untyped-def]
    """Warp the rows of a span, end excluded, whose segments have the same displacements."""
    (y, end), last, width, pitch = span, before.shape[0] - 1, before.shape[1], lines.shape[1]
    for segment in range(places.shape[0]):
        right, down = places[segment, 0], places[segment, 1]
        weights = parts[segment, 0], parts[segment, 1], parts[segment, 2], parts[segment, 3]
        first, line = segment * SEGMENT_SIZE, y % LINE_COUNT * pitch + segment * SEGMENT_SIZE
        if segment < columns[1] or segment >= columns[2]:
            for row in range(y, end):
                _take_border(before, row + down, first + right, beside)
                take_segment(beside, 0, 2 * SEGMENT_SIZE, weights, lines, line + (row - y) * pitch, pitch)
        elif end - y == GROUP_ROWS and y + down >= 0 and end + down <= last:
            place = (y + down) * width + first + right
            take_segments(samples, place, width, weights, lines, line, pitch)
        else:
            for row in range(y + down, end + down):
                upper, lower = min(max(row, 0), last) * width, min(max(row + 1, 0), last) * width
                place = upper + first + right
                take_segment(samples, place, lower - upper, weights, lines, line, pitch)
                line += pitch


@compiled
def _take_border(before, y, x, beside):  # type: ignore[no-untyped-def]
    """Copy a segment and the one below it that are partly outside the plane, repeating its border."""
    last, width = before.shape[0] - 1, before.shape[1]
    upper, lower = min(max(y, 0), last), min(max(y + 1, 0), last)
    for number in range(SEGMENT_SIZE + 1):
        column = min(max(x + number, 0), width - 1)
        beside[number], beside[2 * SEGMENT_SIZE + number] = before[upper, column], before[lower, column]


def whole_segments(width: int) -> int:
    """Return the smallest width of whole segments that holds a row."""
    return -(-width // SEGMENT_SIZE) * SEGMENT_SIZE
