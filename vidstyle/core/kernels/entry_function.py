"""Emits the function through which Python calls a kernel. Uses undocumented interfaces of Numba."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import Any

from llvmlite import ir
from numba.core import types
from numba.core.registry import cpu_target
from numba.np.arrayobj import make_array, populate_array

from vidstyle.core.kernels.arguments import ADDRESSES, MIN_UNLOCKED_NUMBERS, is_array_type
from vidstyle.core.kernels.declare import FAILED, OTHER_TYPES, SUCCEEDED, ArgumentType, Compiled

OBJECT_SIZE, TUPLE_SIZE = object.__basicsize__, tuple.__basicsize__
"""Bytes of a Python object up to its type, which its own fields follow, and of a tuple before its items. The
fields of an array are data, dimensions, shape, strides, base, data type, flags."""
POINTER_SIZE = 8
ADDRESS = ir.IntType(8).as_pointer()
WORD, NUMBER = ir.IntType(64), ir.IntType(32)


class EntryFunction:
    """Emits a C function that checks and reads the arguments of a call, and calls a compiled function.

    The function takes a table of `address_table` and the tuple of arguments. It returns SUCCEEDED, FAILED, or
    OTHER_TYPES if the arguments have other types than `kinds`. It is called with Python's lock.

    Args:
        description: Numba's, of the compiled function.
    """

    def __init__(
        self, module: ir.Module, name: str, description: Any, kinds: tuple[ArgumentType, ...]
    ) -> None:
        self._context, self._description, self._kinds = cpu_target.target_context, description, kinds
        function = ir.Function(module, ir.FunctionType(NUMBER, [ADDRESS, ADDRESS]), name)
        self._table, self._arguments = function.args
        self._builder = ir.IRBuilder(function.append_basic_block())
        self._others = function.append_basic_block()
        self._callee = self._context.declare_function(module, description)
        self._own = count(len(ADDRESSES))
        self._numbers = ir.Constant(WORD, 0)

    def emit(self) -> None:
        """Emit its body."""
        arguments = self._items(self._arguments, self._kinds, self._description.argtypes)
        is_long = self._builder.icmp_signed(">", self._numbers, ir.Constant(WORD, MIN_UNLOCKED_NUMBERS))
        thread = self._builder.alloca(ADDRESS)
        with self._builder.if_then(is_long):
            save = self._function("PyEval_SaveThread", ADDRESS)
            self._builder.store(self._builder.call(save, []), thread)
        call_types = self._description.restype, self._description.argtypes
        call = self._context.call_conv.call_function
        status, _ = call(self._builder, self._callee, *call_types, arguments)
        with self._builder.if_then(is_long):
            restore = self._function("PyEval_RestoreThread", ir.VoidType(), ADDRESS)
            self._builder.call(restore, [self._builder.load(thread)])
        results = (ir.Constant(NUMBER, each) for each in (FAILED, SUCCEEDED))
        self._builder.ret(self._builder.select(status.is_error, *results))
        self._builder.position_at_end(self._others)
        self._builder.ret(ir.Constant(NUMBER, OTHER_TYPES))

    def _items(self, address: Any, kinds: Sequence[ArgumentType], of: Sequence[types.Type]) -> list[Any]:
        """Return the values of a tuple's items; `of`: their types, as Numba names them."""
        self._require_type(address, "tuple")
        self._require(self._field(address, OBJECT_SIZE, WORD), ir.Constant(WORD, len(kinds)))
        places = (TUPLE_SIZE + POINTER_SIZE * number for number in range(len(kinds)))
        items = [self._field(address, place, ADDRESS) for place in places]
        return [self._value(*each) for each in zip(items, kinds, of, strict=True)]

    def _value(self, address: Any, kind: ArgumentType, of: Any) -> Any:
        builder = self._builder
        if isinstance(kind, Compiled):
            self._require(address, self._address(next(self._own)))
            return self._context.get_dummy_value()
        if is_array_type(kind):
            return self._array(address, kind, of)
        if isinstance(kind, tuple):
            return self._context.make_tuple(builder, of, self._items(address, kind, of.types))
        self._require_type(address, kind)
        if kind is int:
            return builder.call(self._function("PyLong_AsLongLong", WORD, ADDRESS), [address])
        if kind is bool:
            return builder.icmp_unsigned("==", address, self._address(ADDRESSES["true"]))
        return self._field(address, OBJECT_SIZE, self._context.get_value_type(of))

    def _array(self, address: Any, kind: ArgumentType, of: Any) -> Any:
        builder, (_, dimensions, is_contiguous) = self._builder, kind
        place = OBJECT_SIZE + POINTER_SIZE
        self._require_type(address, "array")
        self._require(self._field(address, place + 4 * POINTER_SIZE, ADDRESS), self._address(next(self._own)))
        self._require(self._field(address, place, NUMBER), ir.Constant(NUMBER, dimensions))
        flags = self._field(address, place + 5 * POINTER_SIZE, NUMBER)
        contiguous = builder.and_(flags, ir.Constant(NUMBER, 1))
        self._require(contiguous, ir.Constant(NUMBER, int(is_contiguous)))

        def numbers(offset: int) -> list[Any]:
            first = self._field(address, offset, ADDRESS)
            return [self._field(first, POINTER_SIZE * axis, WORD) for axis in range(dimensions)]

        shape, strides = numbers(place + POINTER_SIZE), numbers(place + 2 * POINTER_SIZE)
        size: Any = ir.Constant(WORD, 1)
        for length in shape:
            size = builder.mul(size, length)
        self._numbers = builder.add(self._numbers, size)
        data = self._field(address, OBJECT_SIZE, self._context.get_data_type(of.dtype).as_pointer())
        array = make_array(of)(self._context, builder)
        item_size = self._context.get_constant(types.intp, of.dtype.bitwidth // 8)
        populate_array(array, data, shape, strides, item_size, meminfo=None)
        return array._getvalue()

    def _require_type(self, address: Any, name: object) -> None:
        found = self._field(address, OBJECT_SIZE - POINTER_SIZE, ADDRESS)
        self._require(found, self._address(ADDRESSES[name]))

    def _require(self, one: Any, other: Any) -> None:
        """Return OTHER_TYPES unless both are the same; continue in a new block."""
        following = self._builder.append_basic_block()
        self._builder.cbranch(self._builder.icmp_unsigned("==", one, other), following, self._others)
        self._builder.position_at_end(following)

    def _address(self, place: int) -> Any:
        return self._field(self._table, POINTER_SIZE * place, ADDRESS)

    def _function(self, name: str, result: ir.Type, *arguments: ir.Type) -> Any:
        pointer = ir.FunctionType(result, arguments).as_pointer()
        return self._builder.bitcast(self._address(ADDRESSES[name]), pointer)

    def _field(self, address: Any, offset: int, of: ir.Type) -> Any:
        place = self._builder.gep(address, [ir.Constant(WORD, offset)])
        return self._builder.load(self._builder.bitcast(place, of.as_pointer()))
