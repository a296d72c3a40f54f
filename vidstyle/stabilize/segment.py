"""Bilinear interpolation of neighbouring samples of a row as SIMD instructions.

LLVM makes no vectors of a loop over a few samples, as it would have to prove that what is read and what is
written are apart.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable
from typing import Any

from vidstyle.core.kernels.intrinsic import Intrinsic

SEGMENT = 16
"""Samples that are moved alike."""


class SegmentIntrinsic(Intrinsic):
    """`take_segment(samples, first, under, weights, line, start)` for compiled functions.

    Writes `SEGMENT` samples of `line`, from `start` on: each is the weighted sum of a sample, of that right
    of it, and of the two below.

    Args of the compiled call:
        samples: a plane as one row, uint16 or float32, contiguous.
        first, under: integers, the index of the first sample, and of the one below it. The caller makes sure
            that `SEGMENT` + 1 samples follow each.
        weights: a tuple of four: of a sample, right of it, below, and below on the right; float32, or
            65536ths in uint16, of a sum of at most 65535.
        line: of the same type, contiguous.
        start: integer.
    """

    def typed(self, void: Any) -> Callable[..., Any]:
        def take_segment(
            typing_context: Any, samples: Any, first: Any, under: Any, weights: Any, line: Any, start: Any
        ) -> Any:
            return void(samples, first, under, weights, line, start), _emit_code

        return take_segment


def _emit_code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    ir: Any = importlib.import_module("llvmlite.ir")
    proxies: Any = importlib.import_module("numba.core.cgutils")
    kinds = signature.args
    samples, line = (
        proxies.create_struct_proxy(kinds[number])(context, builder, arguments[number]).data
        for number in (0, 4)
    )
    item, index = context.get_data_type(kinds[0].dtype), ir.IntType(64)
    floats, row = item == ir.FloatType(), ir.VectorType(item, SEGMENT)
    wide = row if floats else ir.VectorType(ir.IntType(32), SEGMENT)
    total = row(None) if floats else row([1] * SEGMENT)
    for number in range(4):
        place = builder.add(arguments[1 + number // 2], ir.Constant(index, number % 2))
        taken = builder.load(builder.bitcast(builder.gep(samples, [place]), row.as_pointer()))
        taken.align = kinds[0].dtype.bitwidth // 8
        weight = builder.extract_value(arguments[3], number)
        same = builder.insert_element(row(ir.Undefined), weight, ir.Constant(ir.IntType(32), 0))
        same = builder.shuffle_vector(same, same, ir.VectorType(ir.IntType(32), SEGMENT)([0] * SEGMENT))
        if floats:
            product = builder.fmul(taken, same, flags=["contract"])
            total = builder.fadd(total, product, flags=["contract"])
        else:
            product = builder.mul(builder.zext(taken, wide), builder.zext(same, wide))
            upper = builder.lshr(product, wide([16] * SEGMENT))
            total = builder.add(total, builder.trunc(upper, row))
    target = builder.bitcast(builder.gep(line, [arguments[5]]), row.as_pointer())
    builder.store(total, target).align = kinds[0].dtype.bitwidth // 8
    return context.get_dummy_value()


take_segment: Any = SegmentIntrinsic()
