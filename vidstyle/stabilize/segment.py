"""Bilinear interpolation of neighbouring samples of a row as SIMD instructions.

LLVM makes no vectors of a loop over a few samples, as it would have to prove that what is read and what is
written are apart.
"""

from __future__ import annotations

import importlib
from typing import Any

import numpy as np

from vidstyle.core.kernels import Compiled, compiled
from vidstyle.core.kernels.intrinsic import Intrinsic

SEGMENT = 16
"""Samples that are moved alike."""


class SegmentIntrinsic(Intrinsic):
    """`take_segment(samples, first, stride, weights, lines, place, pitch)` for compiled functions.

    Writes `SEGMENT` samples in each of a number of rows: each is the weighted sum of a sample, of that right
    of it, and of the two below. The rows are written out one after the other, not as a loop: out of a loop
    LLVM takes the widening of the weights, and then no longer sees that products of 16 bits do.

    Args:
        rows: how many.

    Args of the compiled call:
        samples: a plane as one row, uint16 or float32, contiguous.
        first, stride: integers, the index of the first sample, and the distance to the one below it. The
            caller makes sure that `SEGMENT` + 1 samples follow each.
        weights: a tuple of four: of a sample, right of it, below, and below on the right; float32, or
            65536ths in uint16, of a sum of at most 65535.
        lines: of the same type, contiguous rows, written from number `place` on.
        place, pitch: integers; the distance from one row to the next.
    """

    def __init__(self, rows: int, plain: Compiled[..., None]) -> None:
        super().__init__(plain)
        self._rows = rows

    def emit(  # type: ignore[override]
        self, builder: Any, samples: Any, first: Any, stride: Any, weights: Any, lines: Any, place: Any,
        pitch: Any,
    ) -> None:  # fmt: skip
        emitter = _Emitter(builder, samples.data.type.pointee)
        factors = [emitter.everywhere(builder.extract_value(weights, number)) for number in range(4)]
        above = emitter.pair(samples.data, first)
        for _ in range(self._rows):
            first = builder.add(first, stride)
            below = emitter.pair(samples.data, first)
            emitter.store(emitter.weighted_sum([*above, *below], factors), lines.data, place)
            above, place = below, builder.add(place, pitch)


class _Emitter:
    """Emits vectors of `SEGMENT` numbers of one type."""

    def __init__(self, builder: Any, item: Any) -> None:
        self._ir: Any = importlib.import_module("llvmlite.ir")
        self._builder, self._row = builder, self._ir.VectorType(item, SEGMENT)
        self._wide = self._ir.VectorType(self._ir.IntType(32), SEGMENT)
        self._is_float = item == self._ir.FloatType()
        self._size = 4 if self._is_float else item.width // 8

    def everywhere(self, number: Any) -> Any:
        """A vector of one number."""
        zero = self._ir.IntType(32)(0)
        alone = self._builder.insert_element(self._row(self._ir.Undefined), number, zero)
        return self._builder.shuffle_vector(alone, alone, self._wide([0] * SEGMENT))

    def pair(self, samples: Any, first: Any) -> list[Any]:
        """The samples from number `first` on, and those right of them."""
        places = first, self._builder.add(first, first.type(1))
        loaded = [self._builder.load(self._address(samples, place)) for place in places]
        for each in loaded:
            each.align = self._size
        return loaded

    def weighted_sum(self, vectors: list[Any], factors: list[Any]) -> Any:
        """The sum of products; of whole numbers their upper halves, and 1."""
        builder = self._builder
        total = self._row(None) if self._is_float else self._row([1] * SEGMENT)
        for vector, factor in zip(vectors, factors, strict=True):
            if self._is_float:
                product = builder.fmul(vector, factor, flags=["contract"])
                total = builder.fadd(total, product, flags=["contract"])
            else:
                product = builder.mul(builder.zext(vector, self._wide), builder.zext(factor, self._wide))
                upper = builder.lshr(product, self._wide([16] * SEGMENT))
                total = builder.add(total, builder.trunc(upper, self._row))
        return total

    def store(self, vector: Any, lines: Any, place: Any) -> None:
        """Write a vector from number `place` on."""
        self._builder.store(vector, self._address(lines, place)).align = self._size

    def _address(self, samples: Any, place: Any) -> Any:
        return self._builder.bitcast(self._builder.gep(samples, [place]), self._row.as_pointer())


GROUP = 4
"""Rows that are moved alike, of which most samples are read once instead of twice."""


@compiled
def _take_segment(samples, first, stride, weights, lines, place, pitch):  # type: ignore[no-untyped-def]
    below, width = first + stride, lines.shape[1]
    of_sample, of_right, of_below, of_both = weights
    for x in range(SEGMENT):
        one, right = samples[first + x], samples[first + x + 1]
        lower, both = samples[below + x], samples[below + x + 1]
        row, column = (place + x) // width, (place + x) % width
        if samples.itemsize == 2:
            lines[row, column] = (
                1 + _upper_half(one, of_sample) + _upper_half(right, of_right)
                + _upper_half(lower, of_below) + _upper_half(both, of_both)
            )  # fmt: skip
        else:
            lines[row, column] = one * of_sample + right * of_right + lower * of_below + both * of_both


@compiled
def _upper_half(sample, weight):  # type: ignore[no-untyped-def]
    return np.uint16(np.uint32(np.uint32(sample) * np.uint32(weight)) >> np.uint32(16))


@compiled
def _take_segments(samples, first, stride, weights, lines, place, pitch):  # type: ignore[no-untyped-def]
    for row in range(GROUP):
        _take_segment(samples, first + row * stride, stride, weights, lines, place + row * pitch, pitch)


take_segment: Any = SegmentIntrinsic(1, _take_segment)
take_segments: Any = SegmentIntrinsic(GROUP, _take_segments)
"""For `GROUP` rows."""
