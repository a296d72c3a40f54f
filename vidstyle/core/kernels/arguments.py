"""How machine code takes the arguments of a kernel: as the tuple of the call, with a table of addresses.

Machine code compares the types of the arguments with the table and reads the numbers itself, which takes a
tenth of the time that Python and `ctypes` need. Addresses change from process to process, so they are no part
of the machine code, which is stored.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from typing import Any

import numpy as np

from vidstyle.core.kernels.declare import ArgumentType, Compiled, own_data_type

MIN_UNLOCKED_NUMBERS = 1 << 14
"""Machine code releases Python's lock if its arrays have more numbers. With fewer, it takes less than about
50 us, and threads that wait for the lock would take longer to take it over."""

_FIXED = {
    "array": np.ndarray,
    "tuple": tuple,
    int: int,
    bool: bool,
    float: float,
    np.float32: np.float32,
    "true": True,
}
_FUNCTIONS = "PyLong_AsLongLong", "PyEval_SaveThread", "PyEval_RestoreThread"
ADDRESSES = {name: place for place, name in enumerate((*_FIXED, *_FUNCTIONS))}
"""The places of types, of the object True and of functions of Python in every table. The data types of arrays
and the kernels among the arguments follow."""


def address_table(kinds: tuple[ArgumentType, ...]) -> Any:
    """Return the table for arguments of these types, which must stay alive as long as the table."""
    functions = (ctypes.cast(getattr(ctypes.pythonapi, name), ctypes.c_void_p).value for name in _FUNCTIONS)
    addresses = [*map(id, _FIXED.values()), *functions, *map(id, _own_objects(kinds))]
    return (ctypes.c_void_p * len(addresses))(*addresses)


def _own_objects(kinds: tuple[ArgumentType, ...]) -> Iterator[object]:
    for kind in kinds:
        if isinstance(kind, Compiled):
            yield kind
        elif isinstance(kind, tuple):
            yield from ([own_data_type(kind[0])] if is_array_type(kind) else _own_objects(kind))


def is_array_type(kind: ArgumentType) -> bool:
    """Return whether the type is an array's."""
    return isinstance(kind, tuple) and kind != () and isinstance(kind[0], np.dtype)
