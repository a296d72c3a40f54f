"""Weighted sums of neighbouring numbers, as SIMD instructions."""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from vidstyle.core.kernels.declare import compiled
from vidstyle.core.kernels.intrinsic import Intrinsic

LANES = 8
"""Numbers of a vector that most processors can permute. Sixteen are hardly faster where they can be, too."""


class AddNeighbors(Intrinsic):
    """`add_neighbors(line, start, step, offsets, weights, tap, windows, taps, out, place)` for kernels.

    Adds a few weighted numbers of a line to each of `LANES` ones; the first of them are written. LLVM would
    gather them one by one, which takes twice as long. Here they are loaded as vectors of neighbours and
    permuted: LLVM has no instruction for that, but uses one of the processor's where each lane is extracted
    and inserted.

    Args of the compiled call:
        line: float32, one row. For tap t it is read at the numbers `start + step * t + offset`.
        start, step, place: int64.
        offsets: LANES int32, 0 to LANES * windows - 1; all numbers up to there lie within the line.
        weights: taps x LANES float32.
        tap: int64, the first one that is added; 0 where sums begin.
        windows, taps: tuples; their lengths are how many vectors the offsets reach over, one or two, and how
            many taps are added. No loop adds them: LLVM would extract the offsets before it.
        out: float32, one row; written from number `place` on.
    """

    def emit(  # type: ignore[override]
        self, builder: Any, line: Any, start: Any, step: Any, offsets: Any, weights: Any, tap: Any,
        windows: Any, taps: Any, out: Any, place: Any,
    ) -> None:  # fmt: skip
        emitter = _Emitter(builder)
        chosen = emitter.load(offsets.data, emitter.number(0), emitter.integers)
        is_first = builder.icmp_signed("==", tap, emitter.number(0))
        before = emitter.load(out.data, place, emitter.floats)
        total = builder.select(is_first, emitter.floats([0.0] * LANES), before)
        at = builder.add(start, builder.mul(tap, step))
        weight = builder.mul(tap, emitter.number(LANES))
        for _ in range(taps.type.count):
            values = emitter.looked_up(line.data, at, chosen, windows.type.count)
            product = builder.fmul(emitter.load(weights.data, weight, emitter.floats), values)
            total = builder.fadd(total, product)
            at, weight = builder.add(at, step), builder.add(weight, emitter.number(LANES))
        builder.store(total, emitter.address(out.data, place, emitter.floats)).align = 4


@compiled
def _add_neighbors(  # type: ignore[no-untyped-def]
    line, start, step, offsets, weights, tap, windows, taps, out, place
):
    for lane in range(LANES):
        total = out[place + lane] if tap else np.float32(0)
        for each in range(tap, tap + len(taps)):
            total += weights[each, lane] * line[start + step * each + offsets[lane]]
        out[place + lane] = total


class _Emitter:
    """Emits loads, and look-ups in one or two vectors."""

    def __init__(self, builder: Any) -> None:
        self._ir: Any = importlib.import_module("llvmlite.ir")
        self._builder = builder
        self.floats = self._ir.VectorType(self._ir.FloatType(), LANES)
        self.integers = self._ir.VectorType(self._ir.IntType(32), LANES)

    def number(self, value: int) -> Any:
        """An index."""
        return self._ir.Constant(self._ir.IntType(64), value)

    def address(self, data: Any, at: Any, kind: Any) -> Any:
        """Of the vector that begins at a number of an array."""
        return self._builder.bitcast(self._builder.gep(data, [at]), kind.as_pointer())

    def load(self, data: Any, at: Any, kind: Any) -> Any:
        """That vector."""
        loaded = self._builder.load(self.address(data, at, kind))
        loaded.align = 4
        return loaded

    def looked_up(self, line: Any, at: Any, offsets: Any, windows: int) -> Any:
        """The numbers of a line at these offsets from one of them."""
        values = self._permuted(self.load(line, at, self.floats), offsets)
        if windows == 1:
            return values
        behind = self._builder.add(at, self.number(LANES))
        others = self._permuted(self.load(line, behind, self.floats), offsets)
        is_behind = self._builder.icmp_unsigned(">=", offsets, self.integers([LANES] * LANES))
        return self._builder.select(is_behind, others, values)

    def _permuted(self, vector: Any, offsets: Any) -> Any:
        """Its numbers at these offsets, modulo their count."""
        inside = self._builder.and_(offsets, self.integers([LANES - 1] * LANES))
        result = self.floats(self._ir.Undefined)
        for lane in map(self._ir.IntType(32), range(LANES)):
            number = self._builder.extract_element(vector, self._builder.extract_element(inside, lane))
            result = self._builder.insert_element(result, number, lane)
        return result


add_neighbors: Any = AddNeighbors(_add_neighbors)
