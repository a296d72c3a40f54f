"""Weighted sums of a few rows, and of a few columns, for each sample of another grid."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels.declare import compiled
from vidstyle.core.kernels.indices import look_up_at

Taps = tuple[np.ndarray, np.ndarray]
"""For each sample the places that it is the sum of, in rising order, and their weights: count x taps."""


def column_taps(taps: Taps) -> Taps:
    """Taps of columns as `weigh_rows_and_columns` takes them.

    They are taps x count, for the sake of vectors, and an even number of taps, of which the last may be 0.
    """
    odd = (0, 0), (0, taps[0].shape[1] % 2)
    index, weight = np.pad(taps[0], odd, "edge"), np.pad(taps[1], odd)
    return np.ascontiguousarray(index.T, np.int32), np.ascontiguousarray(weight.T)


def weigh_rows_and_columns(
    plane: np.ndarray, rows: Taps, columns: Taps, out: np.ndarray, columns_first: bool = False
) -> None:
    """Each sample a weighted sum of a few rows, and of a few columns of that.

    Args:
        plane: N x W.
        columns: from `column_taps`.
        out: float32, written.
        columns_first: the columns before the rows, which is faster where there are fewer rows before; the
            same for all bands of a plane, as it rounds differently.
    """
    if columns_first:
        first, end = rows[0][0, 0], rows[0][-1, -1] + 1
        wide = np.empty((end - first, out.shape[1]), np.float32)
        _enlarge(plane[first:end], rows[0] - first, rows[1], *columns, wide, out)
    else:
        _gather(plane, *rows, *columns, np.empty(plane.shape[1], np.float32), out)


@compiled
def _enlarge(plane, row_index, row_weight, index, weight, wide, out):  # type: ignore[no-untyped-def]
    """`_gather` with columns first, which are scattered: there are fewer rows before than after."""
    for row in range(wide.shape[0]):
        _weigh_columns(plane[row], index, weight, wide[row])
    last = row_index.shape[1] - 1
    for row in range(out.shape[0]):
        for tap in range(0, last + 1, 2):
            beside = min(tap + 1, last)
            second = row_weight[row, beside] if beside > tap else np.float32(0)
            one, other = wide[row_index[row, tap]], wide[row_index[row, beside]]
            _weigh_two(one, row_weight[row, tap], other, second, tap > 0, out[row])


@compiled(noalias=True)
def _weigh_two(one, first, other, second, adds, out):  # type: ignore[no-untyped-def]
    if adds:
        for x in range(out.size):
            out[x] += first * one[x] + second * other[x]
    else:
        for x in range(out.size):
            out[x] = first * one[x] + second * other[x]


@compiled
def _gather(plane, row_index, row_weight, index, weight, line, out):  # type: ignore[no-untyped-def]
    for row in range(out.shape[0]):
        for x in range(plane.shape[1]):
            line[x] = 0
        for tap in range(row_index.shape[1]):
            part = row_weight[row, tap]
            if part != 0:
                source = row_index[row, tap]
                for x in range(plane.shape[1]):
                    line[x] += part * plane[source, x]
        _weigh_columns(line, index, weight, out[row])


@compiled(noalias=True)
def _weigh_columns(line, index, weight, out):  # type: ignore[no-untyped-def]
    """Two taps at once, in their order."""
    for x in range(out.size):
        first = weight[0, x] * line[look_up_at(index[0, x])]
        out[x] = first + weight[1, x] * line[look_up_at(index[1, x])]
    for tap in range(2, index.shape[0], 2):
        for x in range(out.size):
            sum_before = out[x] + weight[tap, x] * line[look_up_at(index[tap, x])]
            out[x] = sum_before + weight[tap + 1, x] * line[look_up_at(index[tap + 1, x])]
