"""Kernels by Numba's public interface alone, where its private one is not the one that `compiler` knows.

They are slower, and compiled in each run. Numba's own cache (`cache=True`) is of no use here. It never finds
a kernel that takes functions as arguments, and adds a file for it in each run. It does not notice changes of
a callee in another file. It executes its files without checking a checksum.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from typing import Any

import numba
import numpy as np
from numba.extending import typeof_impl

from vidstyle.core.kernels.declare import ArgumentType, Compiled, Intrinsic


def entry(compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> Callable[..., bool]:
    """Return a function that takes the flattened arguments of a kernel, and runs it."""
    run = _dispatcher(compiled)

    def call(*flat: Any) -> bool:
        run(*_nested(kinds, iter(flat)))
        return False

    return call


def install() -> None:
    """Have Numba compile kernels and intrinsics that kernels name as plain functions."""
    typeof_impl.register(Compiled)(lambda kernel, _: numba.typeof(_dispatcher(kernel)))
    typeof_impl.register(Intrinsic)(lambda intrinsic, _: numba.typeof(_dispatcher(intrinsic.plain)))


@cache
def _dispatcher(compiled: Compiled) -> Any:
    return numba.njit(nogil=True, error_model="numpy", fastmath=compiled.fastmath)(compiled.function)


def _nested(kinds: tuple[ArgumentType, ...], flat: Iterator[Any]) -> Iterator[Any]:
    """Arguments as they were before they were flattened."""
    for kind in kinds:
        if isinstance(kind, Compiled):
            yield _dispatcher(kind)
        elif isinstance(kind, tuple) and not isinstance(kind[0], np.dtype):
            yield tuple(_nested(kind, flat))
        else:
            yield next(flat)
