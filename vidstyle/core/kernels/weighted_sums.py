"""Weighted sums of scattered pixels, as SIMD instructions."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

from vidstyle.core.kernels.intrinsic import Intrinsic

LANES, CHANNELS = 8, 4


class WeightedSums(Intrinsic):
    """`weighted_sums(pixels, at, offsets, weights, first, last, sums)` for compiled functions.

    Adds up pixels of four channels with the weights that they have in eight sectors: for all numbers
    first..last - 1 the pixel that begins at number `at + offsets[number]`, times `weights[number]`, and the
    one at `at - offsets[number]` with the same weights for the opposite sectors. LLVM keeps the sums of this
    loop in scalars.

    Args of the compiled call:
        pixels: float32, one row; four channels of each pixel lie side by side.
        at, first, last: int64.
        offsets: int64.
        weights: numbers x 8 float32.
        sums: 4 x 8 float32, written.
    """

    def typed(self, void: Any) -> Callable[..., Any]:
        def weighted_sums(
            typing_context: Any, pixels: Any, at: Any, offsets: Any, weights: Any, first: Any, last: Any,
            sums: Any,
        ) -> Any:  # fmt: skip
            return void(pixels, at, offsets, weights, first, last, sums), _emit

        return weighted_sums


def _emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    ir: Any = importlib.import_module("llvmlite.ir")
    numba: Any = importlib.import_module("numba.core.cgutils")
    pixels, at, offsets, weights, first, last, sums = (
        numba.create_struct_proxy(kind)(context, builder, value).data if hasattr(kind, "ndim") else value
        for kind, value in zip(signature.args, arguments, strict=True)
    )
    vector, number_type = ir.VectorType(ir.FloatType(), LANES), ir.IntType(64)
    zeros, lanes = ir.Constant(vector, [0.0] * LANES), ir.VectorType(ir.IntType(32), LANES)

    def vector_at(data: Any, number: Any) -> Any:
        start = builder.gep(data, [builder.mul(number, ir.Constant(number_type, LANES))])
        return builder.bitcast(start, vector.as_pointer())

    def in_all_lanes(value: Any) -> Any:
        first_lane = builder.insert_element(zeros, value, ir.Constant(ir.IntType(32), 0))
        return builder.shuffle_vector(first_lane, zeros, ir.Constant(lanes, [0] * LANES))

    def add_pixel(start: Any, weight: Any, totals: list[Any]) -> None:
        pixel = builder.gep(pixels, [start])
        for channel, total in enumerate(totals):
            value = builder.load(builder.gep(pixel, [ir.Constant(number_type, channel)]))
            product = builder.fmul(weight, in_all_lanes(value), flags=["contract"])
            builder.store(builder.fadd(builder.load(total), product, flags=["contract"]), total)

    ahead, behind = ([numba.alloca_once(builder, vector) for _ in range(CHANNELS)] for _ in range(2))
    for total in (*ahead, *behind):
        builder.store(zeros, total)
    step = ir.Constant(number_type, 1)
    with numba.for_range_slice(builder, first, last, step, inc=True) as (number, _):
        weight, offset = (
            builder.load(vector_at(weights, number)),
            builder.load(builder.gep(offsets, [number])),
        )
        weight.align = 4
        add_pixel(builder.add(at, offset), weight, ahead)
        add_pixel(builder.sub(at, offset), weight, behind)
    opposite = ir.Constant(lanes, [(lane + LANES // 2) % LANES for lane in range(LANES)])
    for channel, (one, other) in enumerate(zip(ahead, behind, strict=True)):
        turned = builder.shuffle_vector(builder.load(other), zeros, opposite)
        target = vector_at(sums, ir.Constant(number_type, channel))
        builder.store(builder.fadd(builder.load(one), turned), target).align = 4
    return context.get_dummy_value()


weighted_sums: Any = WeightedSums()
