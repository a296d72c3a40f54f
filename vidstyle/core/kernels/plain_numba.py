"""Kernels by Numba's public interface alone, where its private one is not the one that `compiler` knows.

They are slower, and compiled in each run. Numba's own cache (`cache=True`) is of no use here. It never finds
a kernel that takes functions as arguments, and adds a file for it in each run. It does not notice changes of
a callee in another file. It executes its files without checking a checksum.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numba
from numba.extending import typeof_impl

from vidstyle.core.kernels.declare import (
    OTHER_TYPES,
    SUCCEEDED,
    ArgumentType,
    Compiled,
    Intrinsic,
    KernelEntry,
    types_of,
)


def entry(compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> KernelEntry:
    """Return a function that runs a kernel."""
    run = _dispatcher(compiled)

    def call(arguments: tuple[Any, ...]) -> int:
        if types_of(arguments) != kinds:
            return OTHER_TYPES
        run(*map(_callable, arguments))
        return SUCCEEDED

    return call


def install() -> None:
    """Have Numba compile kernels and intrinsics that kernels name as plain functions."""
    typeof_impl.register(Compiled)(lambda kernel, _: numba.typeof(_dispatcher(kernel)))
    typeof_impl.register(Intrinsic)(lambda intrinsic, _: numba.typeof(_dispatcher(intrinsic.plain)))


@cache
def _dispatcher(compiled: Compiled) -> Any:
    return numba.njit(nogil=True, error_model="numpy", fastmath=compiled.fastmath)(compiled.function)


def _callable(argument: Any) -> Any:
    """Return an argument with what Numba calls in place of kernels."""
    if isinstance(argument, tuple):
        return tuple(map(_callable, argument))
    return _dispatcher(argument) if isinstance(argument, Compiled) else argument
