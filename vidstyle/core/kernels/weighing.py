"""Weighted sums of a few rows, and of a few columns, for each sample of another grid."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vidstyle.core.kernels.aligned import aligned
from vidstyle.core.kernels.declare import Compiled, compiled
from vidstyle.core.kernels.indices import look_up_at
from vidstyle.core.kernels.neighbors import add_neighbors
from vidstyle.core.kernels.vectors import VECTOR_LANES

Taps = tuple[np.ndarray, np.ndarray]
"""For each sample the first of the places that it is the sum of, count int64, and the weights of that one and
of the next ones, count x taps float32. Places beyond the ends of a plane stand for its ends."""


@dataclass(frozen=True)
class Columns:
    """Taps of the columns of rows with several channels side by side, as tables for a kernel.

    Attributes:
        channels: how many.
        left, right: how many numbers a row is extended by.
        weigh: the kernel; takes an extended row, `tables` and the row that it writes.
    """

    channels: int
    left: int
    right: int
    weigh: Compiled[..., None]
    tables: tuple[Any, ...]

    @classmethod
    def of(cls, taps: Taps, width: int, channels: int = 1) -> Columns:
        """Return the columns of rows of `width` pixels."""
        even = np.pad(taps[1], ((0, 0), (0, taps[1].shape[1] % 2)))
        weights = np.repeat(even, channels, axis=0)
        left = channels * max(0, -int(taps[0].min()))
        places = left + (channels * taps[0][:, None] + np.arange(channels)).reshape(-1)
        right = max(0, int(places.max()) + channels * weights.shape[1] - left - channels * width)
        blocks = np.pad(places, (0, -len(places) % VECTOR_LANES), "edge").reshape(-1, VECTOR_LANES)
        windows = int(np.ptp(blocks, axis=1).max()) // VECTOR_LANES + 1
        if windows > 2:
            far = places.astype(np.int32), np.ascontiguousarray(weights.T)
            return cls(channels, left, right, _weigh_far, (*far, channels))
        near = _near_tables(blocks, weights, windows)
        return cls(channels, left, right + VECTOR_LANES * (windows + 1), _weigh_near, (*near, channels))


def _near_tables(blocks: np.ndarray, weights: np.ndarray, windows: int) -> tuple[Any, ...]:
    """Tables for `add_neighbors`.

    Args:
        blocks: blocks x VECTOR_LANES, the first places.
        weights: numbers x taps.
        windows: how many vectors the places of a block reach over.
    """
    starts = blocks.min(axis=1)
    offsets = (blocks - starts[:, None]).astype(np.int32)
    whole = np.pad(weights, ((0, blocks.size - len(weights)), (0, 0)))
    by_block = whole.reshape(*blocks.shape, -1).transpose(0, 2, 1)
    at_once = next(count for count in (8, 6, 4, 2) if weights.shape[1] % count == 0)
    return starts, aligned(offsets), aligned(by_block), (0,) * windows, (0,) * at_once


def weigh_rows_and_columns(
    plane: np.ndarray, rows: Taps, columns: Columns, out: np.ndarray, columns_first: bool = False
) -> None:
    """Each sample a weighted sum of a few rows, and of a few columns of that.

    Args:
        plane: N x W.
        out: float32, written.
        columns_first: whether columns come before rows, which is faster if the source has fewer rows; use
            the same for all bands of a plane, as the order changes the rounding.
    """
    line = np.empty(columns.left + plane.shape[1] + columns.right, np.float32)
    how = columns.weigh, columns.tables, columns.channels, columns.left
    if columns_first:
        recent = np.empty((rows[1].shape[1], out.shape[1]), np.float32)
        _weigh_columns_first(plane, *rows, *how, line, recent, out)
    else:
        _weigh_rows_first(plane, *rows, *how, line, out)


@compiled
def _weigh_rows_first(plane, first, weights, weigh, tables, channels, left, line, out):  # type: ignore[no-untyped-def]
    height, width = plane.shape
    for row in range(out.shape[0]):
        weigh_rows(plane, height, first[row], weights[row], line[left : left + width])
        _extend(line, left, width, channels)
        weigh(line, tables, out[row])


@compiled
def _weigh_columns_first(  # type: ignore[no-untyped-def]
    plane, first, weights, weigh, tables, channels, left, line, recent, out
):
    """Keep the recent rows that contribute to one row of the result."""
    height, width = plane.shape
    made = max(first[0], 0)
    for row in range(out.shape[0]):
        while made < min(first[row] + weights.shape[1], height):
            _copy(plane[made], line[left : left + width])
            _extend(line, left, width, channels)
            weigh(line, tables, recent[made % recent.shape[0]])
            made += 1
        weigh_rows(recent, height, first[row], weights[row], out[row])


@compiled(noalias=True)
def _copy(row, out):  # type: ignore[no-untyped-def]
    for x in range(out.size):
        out[x] = row[x]


@compiled
def _extend(line, left, width, channels):  # type: ignore[no-untyped-def]
    """Repeat the pixels at both ends of the row that begins at number `left`."""
    for x in range(left - 1, -1, -1):
        line[x] = line[x + channels]
    for x in range(left + width, line.size):
        line[x] = line[x - channels]


@compiled
def weigh_rows(rows, height, first, weights, out):  # type: ignore[no-untyped-def]
    """The weighted sum of some rows of a plane from number `first` on.

    Args:
        rows: all rows of the plane; or its recent ones, with number n at index n modulo their count.
        height: of the plane.
        out: one row, written.
    """
    last = weights.size - 1
    for tap in range(0, last + 1, 4):
        one = _row(rows, height, first + tap)
        other = _row(rows, height, first + min(tap + 1, last))
        pair = weights[tap], _weight(weights, tap + 1)
        if tap + 1 >= last:
            _weigh_two(rows, (one, other), pair, tap > 0, out)
        else:
            third = _row(rows, height, first + tap + 2)
            fourth = _row(rows, height, first + min(tap + 3, last))
            next_pair = weights[tap + 2], _weight(weights, tap + 3)
            _weigh_four(rows, (one, other, third, fourth), (*pair, *next_pair), tap > 0, out)


@compiled
def _row(rows, height, place):  # type: ignore[no-untyped-def]
    return min(max(place, 0), height - 1) % rows.shape[0]


@compiled
def _weight(weights, tap):  # type: ignore[no-untyped-def]
    return weights[tap] if tap < weights.size else np.float32(0)


@compiled(noalias=True)
def _weigh_two(rows, numbers, weights, adds, out):  # type: ignore[no-untyped-def]
    a, b = numbers
    of_a, of_b = weights
    if adds:
        for x in range(out.size):
            out[x] += of_a * np.float32(rows[a, x]) + of_b * np.float32(rows[b, x])
    else:
        for x in range(out.size):
            out[x] = of_a * np.float32(rows[a, x]) + of_b * np.float32(rows[b, x])


@compiled(noalias=True)
def _weigh_four(rows, numbers, weights, adds, out):  # type: ignore[no-untyped-def]
    a, b, c, d = numbers
    of_a, of_b, of_c, of_d = weights
    if adds:
        for x in range(out.size):
            before = out[x] + (of_a * np.float32(rows[a, x]) + of_b * np.float32(rows[b, x]))
            out[x] = before + (of_c * np.float32(rows[c, x]) + of_d * np.float32(rows[d, x]))
    else:
        for x in range(out.size):
            before = of_a * np.float32(rows[a, x]) + of_b * np.float32(rows[b, x])
            out[x] = before + (of_c * np.float32(rows[c, x]) + of_d * np.float32(rows[d, x]))


@compiled
def _weigh_near(line, tables, out):  # type: ignore[no-untyped-def]
    """By blocks of numbers that are made of neighbouring ones; the last ones of the line are scratch."""
    starts, offsets, weights, windows, taps, step = tables
    whole, rest = out.size // VECTOR_LANES, out.size % VECTOR_LANES
    scratch = line[line.size - VECTOR_LANES :]
    for tap in range(0, weights.shape[1], len(taps)):
        for block in range(whole):
            how = offsets[block], weights[block], tap, windows, taps
            add_neighbors(line, starts[block], step, *how, out, VECTOR_LANES * block)
        if rest:
            how = offsets[whole], weights[whole], tap, windows, taps
            add_neighbors(line, starts[whole], step, *how, scratch, 0)
    for x in range(rest):
        out[VECTOR_LANES * whole + x] = scratch[x]


@compiled(noalias=True)
def _weigh_far(line, tables, out):  # type: ignore[no-untyped-def]
    """Two taps at once, in their order."""
    places, weights, step = tables
    out[:] = 0
    for tap in range(0, weights.shape[0], 2):
        for x in range(out.size):
            place = places[x] + np.int32(step * tap)
            one, other = line[look_up_at(place)], line[look_up_at(place + np.int32(step))]
            out[x] = (out[x] + weights[tap, x] * one) + weights[tap + 1, x] * other
