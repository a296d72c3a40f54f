"""Emits LLVM instructions on vectors, for all intrinsics."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

VECTOR_LANES = 8
"""Numbers of 32 bits in a vector that most processors can permute. Sixteen are hardly faster."""


class VectorEmitter:
    """Emits loads, stores and permutations of vectors.

    Args:
        builder: an `llvmlite.ir.IRBuilder`.
    """

    def __init__(self, builder: Any) -> None:
        self.ir: Any = importlib.import_module("llvmlite.ir")
        self.builder = builder

    def floats(self, lanes: int) -> Any:
        """Return the type of vectors of float32."""
        return self.ir.VectorType(self.ir.FloatType(), lanes)

    def integers(self, lanes: int, bits: int = 32) -> Any:
        """Return the type of vectors of integers."""
        return self.ir.VectorType(self.ir.IntType(bits), lanes)

    def index(self, value: Any) -> Any:
        """Return a constant index of an integer, or the index that it is already."""
        return self.ir.Constant(self.ir.IntType(64), value) if isinstance(value, int) else value

    def address(self, data: Any, at: Any, kind: Any) -> Any:
        """Return the address of what begins at an item of an array, or at a byte, by the type of `data`."""
        return self.builder.bitcast(self.builder.gep(data, [self.index(at)]), kind.as_pointer())

    def load(self, data: Any, at: Any, kind: Any, align: int = 4) -> Any:
        """Load what begins there."""
        loaded = self.builder.load(self.address(data, at, kind))
        loaded.align = align
        return loaded

    def store(self, value: Any, data: Any, at: Any, align: int = 4) -> None:
        """Store a value there."""
        self.builder.store(value, self.address(data, at, value.type)).align = align

    def permute(self, one: Any, other: Any, lanes: Sequence[int]) -> Any:
        """Return a vector of these lanes of two vectors; lanes of the second follow the first."""
        mask = self.ir.Constant(self.integers(len(lanes)), list(lanes))
        return self.builder.shuffle_vector(one, other, mask)

    def spread(self, number: Any, kind: Any) -> Any:
        """Return a vector of a type that has one number in all lanes."""
        alone = self.builder.insert_element(kind(self.ir.Undefined), number, self.ir.IntType(32)(0))
        return self.permute(alone, alone, [0] * kind.count)

    def variable(self, value: Any) -> Any:
        """Return the address of a variable that has this value."""
        with self.builder.goto_entry_block():  # within a loop it would be a new one each time
            place = self.builder.alloca(value.type)
        self.builder.store(value, place)
        return place

    @contextmanager
    def loop(self, first: Any, last: Any) -> Iterator[Any]:
        """Emit the block as a loop over the numbers first..last - 1; yield the number."""
        builder, before = self.builder, self.builder.block
        head, body, behind = (builder.append_basic_block() for _ in range(3))
        builder.branch(head)
        builder.position_at_end(head)
        number = builder.phi(first.type)
        number.add_incoming(first, before)
        builder.cbranch(builder.icmp_signed("<", number, last), body, behind)
        builder.position_at_end(body)
        yield number
        number.add_incoming(builder.add(number, first.type(1)), builder.block)
        builder.branch(head)
        builder.position_at_end(behind)
