"""Numba kernels: `@compiled` compiles a function at its first call.

Numba is imported only then, and its cache is in the user's cache folder, so that importing a module with
kernels is cheap and works where nothing may be written.
"""

from __future__ import annotations

import functools
import hashlib
import importlib
import logging
import os
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, Generic, ParamSpec, TypeVar, overload

import numpy as np

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

log = logging.getLogger("vidstyle")

_numba_lock = threading.Lock()

TIE_LIFT = np.float32(5e-5)
"""Added to a value before it is compared with the border between two tones, so that ties go to the upper one.

Many values lie exactly on a border: 8-bit codes, and middle gray wherever a difference is zero. Rounding of a
matrix, or of a GPU's 16-bit textures, which is up to 2.3e-5, must not decide there."""


class Compiled(Generic[Arguments, Result]):
    """A function that is compiled for each combination of argument types; it releases the GIL.

    A compiled function may call another one by its module-level name.

    Attributes:
        function: the Python function itself.
    """

    def __init__(self, function: Callable[Arguments, Result], fastmath: bool) -> None:
        functools.update_wrapper(self, function)
        self.function = function
        # Python's division checks for zero each time, which prevents vectorization.
        self._options = {"nogil": True, "fastmath": fastmath, "error_model": "numpy"}
        self._machine_code: Any = None

    def __call__(self, *arguments: Arguments.args, **named: Arguments.kwargs) -> Result:
        """Run the function, compiled for arguments of these types."""
        machine_code = self._machine_code or self._build()
        return machine_code(*arguments, **named)  # type: ignore[no-any-return]

    @property
    def _numba_type_(self) -> Any:
        """Numba's protocol for globals that are called from compiled code."""
        return (self._machine_code or self._build())._numba_type_

    def _build(self) -> Any:
        with _numba_lock:
            numba: Any = importlib.import_module("numba")
            folder = self._cache_folder()
            if not folder.exists():
                _announce_compilation()
            previous, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(folder)
            try:
                self._machine_code = numba.njit(cache=True, **self._options)(self.function)
            except RuntimeError:  # no folder may be written to
                self._machine_code = numba.njit(**self._options)(self.function)
            finally:
                numba.config.CACHE_DIR = previous
        return self._machine_code

    def _cache_folder(self) -> Path:
        """Named by the contents of the called functions' files, as Numba checks only the caller's."""
        digest = hashlib.sha256()
        for file in map(Path, sorted(self._source_files())):
            digest.update(file.read_bytes() if file.is_file() else b"")
        return user_cache() / "kernels" / digest.hexdigest()[:16]

    def _source_files(self) -> set[str]:
        code = self.function.__code__
        named = (self.function.__globals__.get(name) for name in code.co_names)
        called = (item for item in named if isinstance(item, Compiled) and item is not self)
        return {code.co_filename}.union(*(item._source_files() for item in called))


@functools.cache
def _announce_compilation() -> None:
    """Once in a process, and only on a terminal, where somebody waits."""
    log.info("compiling for this processor, once: it takes a few seconds", extra={"only_on_terminal": True})


@overload
def compiled(function: Callable[Arguments, Result], /) -> Compiled[Arguments, Result]: ...


@overload
def compiled(
    *, fastmath: bool = False
) -> Callable[[Callable[Arguments, Result]], Compiled[Arguments, Result]]: ...


def compiled(function: Any = None, /, *, fastmath: bool = False) -> Any:
    """Declare a kernel: `@compiled`, or `@compiled(fastmath=True)` where rounding may be reordered.

    Args:
        fastmath: lets the compiler reorder sums and assume that there are no NaNs.

    >>> @compiled
    ... def double(number):
    ...     return 2 * number
    >>> double.function(21)
    42
    """
    if function is None:
        return lambda declared: Compiled(declared, fastmath)
    return Compiled(function, fastmath)


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


def mix_channels(color: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """Multiply RGB, N x W x 3 float32, by a 3 x 4 matrix whose last column is added; clipped to 0..1, new.

    Not `cv2.transform`, which rounds the last pixels of an array differently, so that the result would depend
    on the bands.
    """
    out = np.empty(color.shape, np.float32)
    _mix_channels(color, matrix.astype(np.float32), out)
    return out


@compiled
def _mix_channels(color, matrix, out):  # type: ignore[no-untyped-def]
    zero, one = np.float32(0), np.float32(1)
    for row in range(color.shape[0]):
        for x in range(color.shape[1]):
            red, green, blue = color[row, x, 0], color[row, x, 1], color[row, x, 2]
            for channel in range(3):
                mixed = matrix[channel, 0] * red + matrix[channel, 1] * green + matrix[channel, 2] * blue
                out[row, x, channel] = min(max(mixed + matrix[channel, 3], zero), one)
