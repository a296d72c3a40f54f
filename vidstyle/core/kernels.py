"""Compiled loops: `@compiled` turns a plain function over arrays into machine code at its first call.

Numba is imported only then, and its cache lies with the user's other caches, so that importing a
module with kernels costs nothing and cannot fail where nothing may be written.
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
"""Added to a value before it is compared with the border between two tones, so that the upper one has ties.

Many values lie just upon a border: the codes of 8 bits, and middle gray wherever a difference is nothing.
Rounding must not decide there: that of a matrix, or of the 16-bit textures in which a GPU keeps pictures,
which are off by up to 2.3e-5."""


class Compiled(Generic[Arguments, Result]):
    """A function that is compiled for each new combination of argument types; it releases the GIL.

    A compiled function may call another one by its module-level name.

    Attributes:
        function: the Python function itself.
    """

    def __init__(self, function: Callable[Arguments, Result], fastmath: bool, parallel: bool) -> None:
        functools.update_wrapper(self, function)
        self.function = function
        # Python's way of dividing looks for zero each time, which keeps the compiler from making vectors.
        self._options = {"nogil": True, "fastmath": fastmath, "parallel": parallel, "error_model": "numpy"}
        self._machine_code: Any = None

    def __call__(self, *arguments: Arguments.args, **named: Arguments.kwargs) -> Result:
        """Run it, compiled for arguments of these types."""
        machine_code = self._machine_code or self._build()
        return machine_code(*arguments, **named)  # type: ignore[no-any-return]

    @property
    def _numba_type_(self) -> Any:
        """What Numba asks a global for that is called from compiled code."""
        return (self._machine_code or self._build())._numba_type_

    def _build(self) -> Any:
        with _numba_lock:
            numba: Any = importlib.import_module("numba")
            folder = self._cache_folder()
            if not folder.exists():
                _say_that_it_takes_time()
            keep, numba.config.CACHE_DIR = numba.config.CACHE_DIR, str(folder)
            try:
                self._machine_code = numba.njit(cache=True, **self._options)(self.function)
            except RuntimeError:  # no folder may be written to
                self._machine_code = numba.njit(**self._options)(self.function)
            finally:
                numba.config.CACHE_DIR = keep
        return self._machine_code

    def _cache_folder(self) -> Path:
        """Named by what the called functions' files hold: Numba itself looks only at the caller's file."""
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
def _say_that_it_takes_time() -> None:
    """Once in a process, and only to somebody who waits at a terminal: of no use in a log."""
    log.info("compiling for this processor, once: it takes a few seconds", extra={"only_on_terminal": True})


@overload
def compiled(function: Callable[Arguments, Result], /) -> Compiled[Arguments, Result]: ...


@overload
def compiled(
    *, fastmath: bool = False, parallel: bool = False
) -> Callable[[Callable[Arguments, Result]], Compiled[Arguments, Result]]: ...


def compiled(function: Any = None, /, *, fastmath: bool = False, parallel: bool = False) -> Any:
    """Declare a kernel: `@compiled`, or `@compiled(fastmath=True)` where rounding may be reordered.

    Args:
        fastmath: lets the compiler reorder sums and assume that there are no NaNs.
        parallel: runs `numba.prange` loops on Numba's own threads.

    >>> @compiled
    ... def double(number):
    ...     return 2 * number
    >>> double.function(21)
    42
    """
    if function is None:
        return lambda declared: Compiled(declared, fastmath, parallel)
    return Compiled(function, fastmath, parallel)


def user_cache() -> Path:
    """The folder for what vidstyle can make again, in the place that the system has for such things.

    Not created here, and perhaps not writable.
    """
    chosen = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    if chosen:
        return Path(chosen) / "vidstyle"
    home = Path(os.path.expanduser("~"))
    return home / ("Library/Caches" if sys.platform == "darwin" else ".cache") / "vidstyle"


def mix_channels(color: np.ndarray, matrix: np.ndarray) -> np.ndarray:
    """RGB, N x W x 3 float32, through a 3 x 4 matrix whose last column is added; cut off to 0..1, new.

    Not `cv2.transform`, which rounds the last pixels of an array otherwise than the rest, so that the
    result would depend on how a picture is divided into bands.
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
