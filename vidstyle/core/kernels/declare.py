"""Kernels: `@compiled` turns a function into machine code at its first call.

Machine code is stored in the user's cache folder as object files, which are loaded without Numba. Only
missing kernels are compiled (`library`, `compiler`), together with others that will soon be needed. So
importing a module with kernels is cheap, and only the first use of a style waits.
"""

from __future__ import annotations

import functools
import importlib
import inspect
import math
import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Generic, ParamSpec, TypeVar, overload

import numpy as np

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")
Kept = TypeVar("Kept", bound=np.ndarray | tuple[np.ndarray, ...])


class KernelError(TypeError):
    """A kernel cannot be compiled by any compiler, or not for arguments of these types."""


class CompilerError(Exception):
    """No kernel can be compiled to an object file with this Numba; the text is the reason."""


SCALARS = int, bool, float, np.float32
"""Types of scalar arguments; kernels also take arrays, and tuples of all these types."""

SUCCEEDED, FAILED, OTHER_TYPES = range(3)
"""Results of machine code; the last one if it was compiled for arguments of other types."""
MAX_RECENT_ENTRIES = 8
"""How many entries of a kernel are tried before the types of arguments are compared in Python."""

ArgumentType = Any
"""The type of an argument: one of `SCALARS`, (data type, dimensions, whether it is C-contiguous) of an array,
a compiled function itself, or a tuple of such types."""


KernelEntry = Callable[[tuple[Any, ...]], int]
"""Machine code of a kernel for arguments of certain types: takes the arguments, returns one of the results
above."""


class Compiled(Generic[Arguments, Result]):
    """A function that is compiled for each combination of argument types.

    It releases the GIL, except for arrays with few numbers (`arguments.MIN_UNLOCKED_NUMBERS`).

    A compiled function may call another one by its module-level name, or one that is an argument, for each of
    which it is compiled. It makes no arrays: what it keeps between loops is among its arguments. Called from
    Python it returns nothing.

    Attributes:
        function: the Python function itself.
        fastmath: whether rounding may be reordered.
        noalias: whether no array among the arguments overlaps another.
    """

    def __init__(self, function: Callable[Arguments, Result], fastmath: bool, noalias: bool) -> None:
        functools.update_wrapper(self, function)
        self.function, self.fastmath, self.noalias = function, fastmath, noalias
        self._entries: dict[tuple[ArgumentType, ...], KernelEntry] = {}
        self._recent: tuple[KernelEntry, ...] = ()

    def __call__(self, *arguments: Arguments.args, **_: Arguments.kwargs) -> Result:
        """Run the function, compiled for arguments of these types.

        Raises:
            RuntimeError: if the function raises an error.
            TypeError: if an argument is no array, compiled function or one of `SCALARS`.
        """
        if _dry_run.calls is None:
            for entry in self._recent:
                result = entry(arguments)
                if result == SUCCEEDED:
                    return None  # type: ignore[return-value]
                if result == FAILED:
                    raise RuntimeError(f"{self.function.__name__} raised an error")
        self._find_and_run(arguments)
        return None  # type: ignore[return-value]

    def _find_and_run(self, arguments: tuple[Any, ...]) -> None:
        """Run the function after it was loaded or compiled, or not called recently with such arguments."""
        kinds = types_of(arguments)
        if _dry_run.calls is not None:
            _dry_run.calls[self, kinds] = None
            return
        entry = self._entries.get(kinds)
        if entry is None:
            library = importlib.import_module("vidstyle.core.kernels.library")
            entry = self._entries[kinds] = library.entry(self, kinds)
        if entry not in self._recent:
            self._recent = (entry, *self._recent)[:MAX_RECENT_ENTRIES]
        result = entry(arguments)
        if result == OTHER_TYPES:  # equal ones that are not the same objects
            result = entry(_plain_arrays(arguments))
        if result != SUCCEEDED:
            raise RuntimeError(f"{self.function.__name__} raised an error")

    def __repr__(self) -> str:
        return f"{self.function.__module__}.{self.function.__qualname__}"

    def __reduce__(self) -> str:
        return self.function.__qualname__

    def source_files(self) -> set[str]:
        """Return the files of the function and of all that it calls."""
        own = {self.function.__code__.co_filename}
        own |= {inspect.getfile(type(item)) for item in self._callees() if not isinstance(item, Compiled)}
        return own.union(*(each.source_files() for each in self._callees() if isinstance(each, Compiled)))

    def _callees(self) -> list[Any]:
        """Kernels and intrinsics that it names."""
        named = map(self.function.__globals__.get, self.function.__code__.co_names)
        return [item for item in named if isinstance(item, Compiled | Intrinsic) and item is not self]


class Intrinsic(ABC):
    """A function for kernels, written as LLVM instructions where LLVM finds no vectors itself.

    It returns nothing.

    Args:
        plain: a compiled function of the same arguments, which does the same without LLVM instructions.
    """

    def __init__(self, plain: Compiled[..., None]) -> None:
        self.plain = plain

    @abstractmethod
    def emit(self, builder: Any, *arguments: Any, **_: Any) -> None:
        """Emit the instructions of one call.

        Args:
            builder: an `llvmlite.ir.IRBuilder`.
            arguments: of the call: values, or the fields of an array, as `data` and `strides`. A subclass
                names them; so they are named for compiled functions.
        """


@overload
def compiled(function: Callable[Arguments, Result], /) -> Compiled[Arguments, Result]: ...


@overload
def compiled(
    *, fastmath: bool = False, noalias: bool = False
) -> Callable[[Callable[Arguments, Result]], Compiled[Arguments, Result]]: ...


def compiled(function: Any = None, /, *, fastmath: bool = False, noalias: bool = False) -> Any:
    """Declare a kernel: `@compiled`, or `@compiled(fastmath=True)` where rounding may be reordered.

    Args:
        fastmath: lets the compiler reorder sums and assume that there are no NaNs.
        noalias: promises that no array among the arguments overlaps another. A loop with look-ups, whose
            places the compiler cannot know, only then becomes vectors. Not for arrays within tuples.

    >>> @compiled
    ... def double(number):
    ...     return 2 * number
    >>> double.function(21)
    42
    """
    if function is None:
        return lambda declared: Compiled(declared, fastmath, noalias)
    return Compiled(function, fastmath, noalias)


def types_of(values: tuple[Any, ...]) -> tuple[ArgumentType, ...]:
    """Return the types of arguments, for which a kernel is compiled."""
    return tuple(map(_type_of, values))


def _type_of(value: Any) -> ArgumentType:
    if isinstance(value, np.ndarray):
        return value.dtype, value.ndim, value.flags.c_contiguous
    if isinstance(value, tuple):
        return types_of(value)
    return value if isinstance(value, Compiled) else type(value)


def own_data_type(dtype: np.dtype) -> np.dtype:
    """Return the one object that NumPy has for a data type, instead of an equal one."""
    return np.dtype(dtype.str)


def _plain_arrays(values: Any) -> Any:
    """Return arguments with arrays that are of no subclass and have NumPy's own objects as data types."""
    if isinstance(values, np.ndarray):
        return values.view(own_data_type(values.dtype), np.ndarray)
    return tuple(map(_plain_arrays, values)) if isinstance(values, tuple) else values


class _DryRun(threading.local):
    calls: dict[tuple[Compiled, tuple[ArgumentType, ...]], None] | None = None


_dry_run = _DryRun()


@contextmanager
def dry_run() -> Iterator[dict[tuple[Compiled, tuple[ArgumentType, ...]], None]]:
    """Within it, calls of kernels in this thread are noted and not carried out.

    Yields:
        The kernels that were called, each with the types of its arguments, in the order of first calls.
    """
    _dry_run.calls = {}
    try:
        yield _dry_run.calls
    finally:
        _dry_run.calls = None


def is_dry_run() -> bool:
    """Return whether calls of kernels in this thread are not carried out: their results hold any values."""
    return _dry_run.calls is not None


def _bytes(arrays: np.ndarray | tuple[np.ndarray, ...]) -> int:
    return arrays.nbytes if isinstance(arrays, np.ndarray) else sum(each.nbytes for each in arrays)


def cached(
    maxsize: int, most_bytes: float = math.inf
) -> Callable[[Callable[Arguments, Kept]], Callable[Arguments, Kept]]:
    """`functools.lru_cache` for arrays that kernels compute: one thread computes one, the others wait.

    A dry run, which computes nothing, neither waits nor leaves anything.

    Args:
        maxsize: maximum number of cached arrays.
        most_bytes: maximum size of all of them; the last one is always cached.
    """

    def declare(function: Callable[Arguments, Kept]) -> Callable[Arguments, Kept]:
        kept: dict[Any, Kept] = {}  # the last used one at the end
        computing = threading.Lock()

        @functools.wraps(function)
        def call(*arguments: Arguments.args, **named: Arguments.kwargs) -> Kept:
            # In a dry run perhaps within a call that computes, for the kernel that it lacks.
            if _dry_run.calls is not None:
                return function(*arguments, **named)
            key = arguments, tuple(named.items())
            with computing:
                result = kept.pop(key, None)
                if result is None:
                    result = function(*arguments, **named)
                    room = most_bytes - _bytes(result)
                    while kept and (len(kept) >= maxsize or sum(map(_bytes, kept.values())) > room):
                        del kept[next(iter(kept))]
                kept[key] = result
                return result

        return call

    return declare
