"""Means of scattered pixels in the sectors around a point, as SIMD instructions."""

from __future__ import annotations

import importlib
from typing import Any

from vidstyle.core.kernels.intrinsic import Intrinsic

SECTORS, CHANNELS = 8, 4
HALF = SECTORS // 2
"""Sectors side by side that a weight is given for: most samples lie in no more."""
LANES = HALF * CHANNELS


class SectorMeans(Intrinsic):
    """`sector_means(pixels, at, offsets, weights, first, last, squarings, out, place)` for kernels.

    A mean of the means of red, green and blue in eight sectors, each weighted by 1 / (1 + (255 v) ^ (2 ^ n)),
    where v is the sector's variance, summed over channels.

    For all numbers first..last - 1 and both columns of `offsets`, the pixel that begins at number
    `at + offset` counts by four weights in the sectors 0 to 3 (first column) or 2 to 5 (second), and the
    one at `at - offset` by the same weights in the four sectors opposite to them. LLVM keeps the sums of
    this loop in scalars.

    Args of the compiled call:
        pixels: float32, one row; red, green, blue and the sum of their squares lie side by side.
        at, first, last, place: int64.
        offsets: numbers x 2 int64.
        weights: numbers x 2 x 4 float32; those of each sector add up to 1.
        squarings: a tuple of n + 1 numbers: its length is known to the compiler.
        out: float32, one row; three numbers are written from number `place` on.
    """

    def emit(  # type: ignore[override]
        self, builder: Any, pixels: Any, at: Any, offsets: Any, weights: Any, first: Any, last: Any,
        squarings: Any, out: Any, place: Any,
    ) -> None:  # fmt: skip
        emitter = _Emitter(builder)
        sums = emitter.sums((pixels.data, at), offsets.data, weights.data, (first, last))
        means = emitter.mean(sums, squarings.type.count - 1)
        target = builder.bitcast(builder.gep(out.data, [place]), means.type.as_pointer())
        builder.store(means, target).align = 4


class _Emitter:
    """Emits the two halves of the function: the loop over samples, and what follows from its sums."""

    def __init__(self, builder: Any) -> None:
        self._ir: Any = importlib.import_module("llvmlite.ir")
        self._builder, self._float, self._index = builder, self._ir.FloatType(), self._ir.IntType(64)

    def sums(self, pixel: tuple[Any, Any], offsets: Any, weights: Any, numbers: tuple[Any, Any]) -> list[Any]:
        """Red, green, blue and squares in eight sectors, each."""
        numba: Any = importlib.import_module("numba.core.cgutils")
        builder, vector = self._builder, self._ir.VectorType(self._float, LANES)
        totals = [numba.alloca_once(builder, vector) for _ in range(4)]
        for total in totals:
            builder.store(self._constant(0.0, LANES), total)
        step = self._ir.Constant(self._index, 1)
        with numba.for_range_slice(builder, *numbers, step, inc=True) as (number, _):
            first = builder.shl(number, step)
            both = self._load(weights, builder.mul(first, self._ir.Constant(self._index, HALF)), 2 * HALF)
            for column in range(2):
                weight = self._lanes(both, both, [column * HALF + lane // CHANNELS for lane in range(LANES)])
                at = builder.add(first, self._ir.Constant(self._index, column))
                offset = builder.load(builder.gep(offsets, [at]))
                self._add_pixel(pixel[0], builder.add(pixel[1], offset), weight, totals[column])
                self._add_pixel(pixel[0], builder.sub(pixel[1], offset), weight, totals[2 + column])
        # In each group of four lanes, one sector: the sectors 0 to 3, 2 to 5, 4 to 7, and 6 to 1.
        from_0, from_2, from_4, from_6 = map(builder.load, totals)
        crossing = [*range(LANES // 2, LANES), *range(LANES, LANES + LANES // 2)]
        low = builder.fadd(from_0, self._lanes(from_6, from_2, crossing))
        high = builder.fadd(from_4, self._lanes(from_2, from_6, crossing))
        return [
            self._lanes(low, high, list(range(channel, 2 * LANES, CHANNELS))) for channel in range(CHANNELS)
        ]

    def mean(self, sums: list[Any], squarings: int) -> Any:
        """Red, green and blue of the mean over all sectors, three lanes."""
        builder, fast = self._builder, ["fast"]
        red, green, blue, variance = sums
        for mean in (red, green, blue):
            variance = builder.fsub(variance, builder.fmul(mean, mean, flags=fast), flags=fast)
        variance = builder.fmul(variance, self._constant(255.0, SECTORS), flags=fast)
        one, zero = self._constant(1.0, SECTORS), self._constant(0.0, SECTORS)
        if squarings == 0:  # rounding may leave it below 0
            variance = builder.select(builder.fcmp_ordered("<", variance, zero), zero, variance)
        for _ in range(squarings):
            variance = builder.fmul(variance, variance, flags=fast)
        shares = builder.fdiv(one, builder.fadd(one, variance, flags=fast), flags=fast)
        parts = [shares, *(builder.fmul(shares, mean, flags=fast) for mean in (red, green, blue))]
        halves = [
            builder.fadd(self._lanes(part, part, [0, 1, 2, 3]), self._lanes(part, part, [4, 5, 6, 7]))
            for part in parts
        ]
        pairs = [self._added(halves[k], halves[k + 1], [0, 4, 1, 5], [2, 6, 3, 7]) for k in (0, 2)]
        whole = self._added(pairs[0], pairs[1], [0, 1, 4, 5], [2, 3, 6, 7])
        total = self._lanes(whole, whole, [0, 0, 0])
        return builder.fdiv(self._lanes(whole, whole, [1, 2, 3]), total, flags=fast)

    def _added(self, one: Any, other: Any, first: list[int], second: list[int]) -> Any:
        return self._builder.fadd(self._lanes(one, other, first), self._lanes(one, other, second))

    def _constant(self, value: float, lanes: int) -> Any:
        return self._ir.Constant(self._ir.VectorType(self._float, lanes), [value] * lanes)

    def _lanes(self, one: Any, other: Any, numbers: list[int]) -> Any:
        mask = self._ir.Constant(self._ir.VectorType(self._ir.IntType(32), len(numbers)), numbers)
        return self._builder.shuffle_vector(one, other, mask)

    def _load(self, data: Any, start: Any, count: int) -> Any:
        """Numbers of an array, a vector."""
        pointer = self._ir.VectorType(self._float, count).as_pointer()
        values = self._builder.load(self._builder.bitcast(self._builder.gep(data, [start]), pointer))
        values.align = 4
        return values

    def _add_pixel(self, pixels: Any, start: Any, weight: Any, total: Any) -> None:
        builder = self._builder
        channels = self._load(pixels, start, CHANNELS)
        pixel = self._lanes(channels, channels, [lane % CHANNELS for lane in range(LANES)])
        product = builder.fmul(weight, pixel, flags=["contract"])
        builder.store(builder.fadd(builder.load(total), product, flags=["contract"]), total)


sector_means: Any = SectorMeans()
