"""Rows of a plane as the plane before shows them, warped along the motion."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled, index_at
from vidstyle.stabilize.segment import SEGMENT, take_segment

STILL = np.zeros((1, 1, 2), np.float32)
"""The flow of a film in which nothing moves."""
WHOLE_PART = 65535
"""The sum of the weights of four samples as `Moves` has them for planes of 16 bits."""

Moves = tuple[np.ndarray, np.ndarray, np.ndarray]
"""For each segment: int32, h x w x 2, whole samples to the right and down; h x w x 4, weights of a sample, of
that right of it, and of the two below, float32, or uint16 of the sum `WHOLE_PART`. For each row of segments:
int32, h x 3, 1 if it has not moved, and the first and the end of those within the plane's columns."""


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


def moves_of(flow: np.ndarray, width: int, dtype: np.dtype) -> Moves:
    """What `warp_row` needs of the flow of a plane's segments, computed once for all of its rows.

    Args:
        flow: where each segment was, in samples of the plane to the right and down; see `in_segments`.
        width: of the plane.
        dtype: of its samples, uint16 or float32.
    """
    places, parts = np.empty(flow.shape, np.int32), np.empty((*flow.shape[:2], 4), dtype)
    rows, whole = np.empty((len(flow), 3), np.int32), 1 if dtype == np.float32 else WHOLE_PART
    _fill_moves(flow, width, np.float32(whole), places, parts, rows)
    return places, parts, rows


@compiled
def warp_row(before, samples, y, moves, beside, line):  # type: ignore[no-untyped-def]
    """Fill a line with row `y` of a plane as the plane before shows it, linear between samples.

    Args:
        before, samples: H x W, and the same as one row; uint16 or float32.
        moves: see `moves_of`.
        beside: 4 x `SEGMENT`, of the same type; scratch.
        line: whole segments, of the same type.
    """
    places, parts, rows = moves
    row = grid_row(y, before.shape[0], rows.shape[0])
    if rows[row, 0]:
        for x in range(before.shape[1]):
            line[x] = before[y, x]
        return
    start, end = rows[row, 1], rows[row, 2]
    _warp_segments(before, samples, y, places[row, start:end], parts[row, start:end], start, line)
    for segment in range(places.shape[1]):
        if segment < start or segment >= end:
            _warp_at_border(before, y, segment, places[row, segment], parts[row, segment], beside, line)


@compiled
def grid_row(y, height, rows):  # type: ignore[no-untyped-def]
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
            first, end = segment * SEGMENT, segment * SEGMENT + SEGMENT
            if first + right < 0:
                rows[row, 1] = segment + 1
            if (end + right >= width or end > width) and segment < rows[row, 2]:
                rows[row, 2] = segment


@compiled
def _warp_segments(before, samples, y, places, parts, start, line):  # type: ignore[no-untyped-def]
    last, width = before.shape[0] - 1, before.shape[1]
    for segment in range(places.shape[0]):
        weights = parts[segment, 0], parts[segment, 1], parts[segment, 2], parts[segment, 3]
        first, upper = (start + segment) * SEGMENT, y + places[segment, 1]
        lower = min(max(upper + 1, 0), last) * width + first + places[segment, 0]
        upper = min(max(upper, 0), last) * width + first + places[segment, 0]
        take_segment(samples, upper, lower, weights, line, first)


@compiled
def _warp_at_border(before, y, segment, place, parts, beside, line):  # type: ignore[no-untyped-def]
    """A segment of which a part comes from outside the plane's columns, whose border is repeated there."""
    last, width = before.shape[0] - 1, before.shape[1]
    upper, lower = min(max(y + place[1], 0), last), min(max(y + place[1] + 1, 0), last)
    for x in range(SEGMENT + 1):
        column = min(max(segment * SEGMENT + place[0] + x, 0), width - 1)
        beside[x], beside[2 * SEGMENT + x] = before[upper, column], before[lower, column]
    weights = parts[0], parts[1], parts[2], parts[3]
    take_segment(beside, 0, 2 * SEGMENT, weights, line, segment * SEGMENT)


def whole_segments(width: int) -> int:
    """The least width of whole segments that holds a row."""
    return -(-width // SEGMENT) * SEGMENT
