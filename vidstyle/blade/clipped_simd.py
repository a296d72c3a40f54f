"""The inner loop of clipped differences as SIMD instructions, as `simd` has it for linear filters."""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np

from vidstyle.blade.simd import FilterEmitter
from vidstyle.core.kernels import compiled
from vidstyle.core.kernels.aligned import aligned
from vidstyle.core.kernels.declare import Intrinsic
from vidstyle.core.kernels.vectors import VECTOR_LANES


def pack_clipped(weights: np.ndarray) -> np.ndarray:
    """Pack weights, bins x clips x size x size, for `add_clipped_block`: bins x numbers float32, aligned.

    The rows of each clip are padded by zeros to whole vectors; row by row, the clips follow one another.
    """
    size = weights.shape[-1]
    rows = np.pad(weights.transpose(0, 2, 1, 3), [(0, 0)] * 3 + [(0, -size % VECTOR_LANES)])
    return aligned(np.ascontiguousarray(rows.reshape(len(rows), -1), np.float32))


class ClippedBlockIntrinsic(Intrinsic):
    """`add_clipped_block(bank, selected, lines, column, sides, clips, out)` for kernels.

    Gain: 720p with two clips and filters of 7 x 7 takes a third of the time of the plain form.

    Adds the weighted clipped differences of the pixels column..column + 7 to `out`.

    Args of the compiled call:
        bank: from `pack_clipped`.
        selected: int32, the filter of each pixel of the row.
        lines: float32, the rows of the windows from the first one on; padded so that windows begin at the
            column of their pixel, and `VECTOR_LANES` more columns can be read.
        sides: two tuples, of which only the lengths are used: the rows of a filter, and the clips.
        clips: float32.
        out: float32, the row of the result.
    """

    def emit(  # type: ignore[override]
        self, builder: Any, bank: Any, selected: Any, lines: Any, column: Any, sides: Any, clips: Any,
        out: Any,
    ) -> None:  # fmt: skip
        size, count = (each.count for each in sides.type.elements)
        _ClippedEmitter(builder, (size, count), (bank, lines), column).emit(selected, clips, out)


@compiled(fastmath=True)
def _add_clipped_block(bank, selected, lines, column, sides, clips, out):  # type: ignore[no-untyped-def]
    for x in range(column, column + VECTOR_LANES):
        out[x] += clipped_sum(bank[selected[x]], lines, x, sides, clips)


@compiled(fastmath=True)
def clipped_sum(weights, lines, x, sides, clips):  # type: ignore[no-untyped-def]
    """Return the weighted clipped differences of one pixel."""
    size, count, total = len(sides[0]), len(sides[1]), np.float32(0)
    width = -(-size // VECTOR_LANES) * VECTOR_LANES
    middle = lines[size // 2, x + size // 2]
    for y in range(size):
        for number in range(count):
            first, clip = (y * count + number) * width, clips[number]
            for i in range(size):
                total += weights[first + i] * min(max(lines[y, x + i] - middle, -clip), clip)
    return total


class _ClippedEmitter(FilterEmitter):
    """Emits the vector instructions; addresses are in bytes."""

    def __init__(self, builder: Any, sides: tuple[int, int], arrays: tuple[Any, Any], column: Any) -> None:
        super().__init__(builder)
        (self._size, self._count), (bank, lines) = sides, arrays
        self._lanes = -(-self._size // VECTOR_LANES) * VECTOR_LANES
        self._filter_bytes = 4 * self._size * self._count * self._lanes
        self._bank, self._column = self._bytes(bank), self._times(column, 4)
        self._lines = list(self._rows(lines, self.index(0), self._size))

    def emit(self, selected: Any, clips: Any, out: Any) -> None:
        """Emit the code for eight pixels."""
        kind = self.floats(self._lanes)
        numbers = [self.load(clips.data, number, self.ir.FloatType()) for number in range(self._count)]
        limits = [(self.spread(self.builder.fneg(each), kind), self.spread(each, kind)) for each in numbers]
        first = self._at(self._bytes(selected), self._column)
        sums = [self._pixel(self._filter_start(first, 4 * x), x, limits) for x in range(VECTOR_LANES)]
        place = self._at(self._bytes(out), self._column)
        before = self.load(place, 0, self.floats(VECTOR_LANES))
        self.store(self._sum(before, self._total_of_each(sums)), place, 0)

    def _pixel(self, start: Any, number: int, limits: list[tuple[Any, Any]]) -> Any:
        """Return partial sums of one pixel; each clip has its own, as additions depend on one another."""
        radius = self._size // 2
        there = self._at(self._lines[radius], self._column)
        middle = self.spread(
            self.load(there, 4 * (number + radius), self.ir.FloatType()), self.floats(self._lanes)
        )
        totals: list[list[Any]] = [[] for _ in limits]
        for row, line in enumerate(self._lines):
            window = self.load(self._at(line, self._column), 4 * number, self.floats(self._lanes))
            difference = self.builder.fsub(window, middle)
            for clip, (low, high) in enumerate(limits):
                limited = self._select("<", self._select(">", difference, low), high)
                weights = self.load(start, 4 * (row * self._count + clip) * self._lanes, limited.type, 32)
                totals[clip] = [reduce(self._sum, [*totals[clip], self._product(weights, limited)])]
        return self._reduce(reduce(self._sum, [each for (each,) in totals]))

    def _select(self, relation: str, vector: Any, limit: Any) -> Any:
        """Keep each element that has this relation to the element of a limit, else use the limit."""
        return self.builder.select(self.builder.fcmp_ordered(relation, vector, limit), vector, limit)


add_clipped_block: Any = ClippedBlockIntrinsic(_add_clipped_block)
