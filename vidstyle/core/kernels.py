"""Kernels: `@compiled` turns a function into machine code at its first call.

Machine code lies in the user's cache folder as object files, which are loaded without Numba. Only a kernel
that is missing there is compiled (`kernel_library`, `kernel_compiler`), together with what else will soon be
needed. So importing a module with kernels is cheap, and only the first use of a style waits.
"""

from __future__ import annotations

import ctypes
import functools
import importlib
import inspect
import os
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeVar, overload

import numpy as np

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

TIE_LIFT = np.float32(5e-5)
"""Added to a value before it is compared with the border between two tones, so that ties go to the upper one.

Many values lie exactly on a border: 8-bit codes, and middle gray wherever a difference is zero. Rounding of a
matrix, or of a GPU's 16-bit textures, which is up to 2.3e-5, must not decide there."""

SCALARS = {int: ctypes.c_int64, bool: ctypes.c_bool, float: ctypes.c_double, np.float32: ctypes.c_float}
"""What a kernel takes besides arrays, and tuples of all of these."""

ArgumentType = Any
"""The type of an argument: one of `SCALARS`, (data type, dimensions, whether it is C-contiguous) of an array,
or a tuple of such types."""


class Compiled(Generic[Arguments, Result]):
    """A function that is compiled for each combination of argument types; it releases the GIL.

    A compiled function may call another one by its module-level name. It makes no arrays: what it keeps
    between loops is among its arguments. Called from Python it returns nothing.

    Attributes:
        function: the Python function itself.
        fastmath: whether rounding may be reordered.
        noalias: whether no array among the arguments overlaps another.
    """

    def __init__(self, function: Callable[Arguments, Result], fastmath: bool, noalias: bool) -> None:
        functools.update_wrapper(self, function)
        self.function, self.fastmath, self.noalias = function, fastmath, noalias
        self._entries: dict[tuple[ArgumentType, ...], Callable[..., object]] = {}

    def __call__(self, *arguments: Arguments.args, **_: Arguments.kwargs) -> Result:
        """Run the function, compiled for arguments of these types.

        Raises:
            RuntimeError: if the function raises an error.
            TypeError: if an argument is neither an array nor one of `SCALARS`.
        """
        kinds = types_of(arguments)
        if _dry_run.calls is not None:
            _dry_run.calls[self, kinds] = None
            return None  # type: ignore[return-value]
        entry = self._entries.get(kinds)
        if entry is None:
            library = importlib.import_module("vidstyle.core.kernel_library")
            entry = self._entries[kinds] = library.entry(self, kinds)
        if entry(*_flat(arguments)):
            raise RuntimeError(f"{self.function.__name__} raised an error")
        return None  # type: ignore[return-value]

    @property
    def _numba_type_(self) -> Any:
        """Numba's protocol for globals that are called from compiled code."""
        return importlib.import_module("vidstyle.core.kernel_compiler").callee_type(self)

    def source_files(self) -> set[str]:
        """The files of the function and of all that it calls."""
        own = {self.function.__code__.co_filename}
        own |= {inspect.getfile(type(item)) for item in self._callees() if not isinstance(item, Compiled)}
        return own.union(*(each.source_files() for each in self._callees() if isinstance(each, Compiled)))

    def _callees(self) -> list[Any]:
        """Kernels and intrinsics that it names."""
        named = map(self.function.__globals__.get, self.function.__code__.co_names)
        return [item for item in named if hasattr(type(item), "_numba_type_") and item is not self]


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
    """The types of arguments, for which a kernel is compiled."""
    return tuple(
        [
            (value.dtype, value.ndim, value.flags.c_contiguous)
            if isinstance(value, np.ndarray)
            else types_of(value)
            if isinstance(value, tuple)
            else type(value)
            for value in values
        ]
    )


def _flat(values: tuple[Any, ...]) -> list[Any]:
    flat: list[Any] = []
    for value in values:
        if isinstance(value, tuple):
            flat += _flat(value)
        else:
            flat.append(value.item() if isinstance(value, np.float32) else value)
    return flat


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


def cached(maxsize: int) -> Callable[[Callable[Arguments, Result]], Callable[Arguments, Result]]:
    """`functools.lru_cache` for what kernels compute: one thread computes it, the others wait.

    A dry run, which computes nothing, neither waits nor leaves anything.
    """

    def declare(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
        remembering: Any = functools.lru_cache(maxsize)(function)
        computing = threading.Lock()

        @functools.wraps(function)
        def call(*arguments: Arguments.args, **named: Arguments.kwargs) -> Result:
            if (
                _dry_run.calls is not None
            ):  # perhaps within a call that computes, for the kernel that it lacks
                return function(*arguments, **named)
            with computing:
                return remembering(*arguments, **named)

        return call

    return declare


def user_cache() -> Path:
    """The user's cache folder of vidstyle; not created here, and perhaps not writable."""
    chosen = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    if chosen:
        return Path(chosen) / "vidstyle"
    home = Path(os.path.expanduser("~"))
    return home / ("Library/Caches" if sys.platform == "darwin" else ".cache") / "vidstyle"


@compiled
def index_at(place, last):  # type: ignore[no-untyped-def]
    """The whole part of a place as an index, 0..last, int32.

    Compared after the cast: NaN passes comparisons of floats where the compiler may assume there is none.
    """
    return min(max(np.int32(place), np.int32(0)), np.int32(last))


@compiled
def look_up_at(index):  # type: ignore[no-untyped-def]
    """An index in 32 bits that cannot be negative: with others the compiler makes no vectors of look-ups."""
    return np.uint32(max(np.int32(index), np.int32(0)))


def mix_channels(color: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Multiply RGB, N x W x 3 float32, by a 3 x 4 matrix whose last column is added; clipped to 0..1, new.

    Not `cv2.transform`, which rounds the last pixels of an array differently, so that the result would depend
    on the bands.
    """
    out = np.empty(color.shape, np.float32)
    _mix_channels(interleaved(color), matrix.astype(np.float32), interleaved(out))
    return out


def interleaved(color: np.ndarray) -> np.ndarray:
    """RGB, N x W x 3, as rows of 3 W numbers for kernels: a view where it is contiguous.

    There, channels lie three numbers apart. Of an array of three dimensions the compiler does not know that,
    and makes no vectors.
    """
    return np.ascontiguousarray(color).reshape(len(color), -1)


@compiled
def _mix_channels(color, matrix, out):  # type: ignore[no-untyped-def]
    zero, one = np.float32(0), np.float32(1)
    a, b, c, d = matrix[0, 0], matrix[0, 1], matrix[0, 2], matrix[0, 3]
    e, f, g, h = matrix[1, 0], matrix[1, 1], matrix[1, 2], matrix[1, 3]
    i, j, k, m = matrix[2, 0], matrix[2, 1], matrix[2, 2], matrix[2, 3]
    for row in range(out.shape[0]):
        for x in range(out.shape[1] // 3):
            red, green, blue = color[row, 3 * x], color[row, 3 * x + 1], color[row, 3 * x + 2]
            out[row, 3 * x] = min(max(a * red + b * green + c * blue + d, zero), one)
            out[row, 3 * x + 1] = min(max(e * red + f * green + g * blue + h, zero), one)
            out[row, 3 * x + 2] = min(max(i * red + j * green + k * blue + m, zero), one)
