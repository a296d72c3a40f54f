"""Machine code of kernels: loads object files from the user's cache folder and compiles missing ones."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import importlib
import math
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np

from vidstyle.core.kernels.arguments import address_table, is_array_type
from vidstyle.core.kernels.compiler_pool import CompilerPool, Kernel
from vidstyle.core.kernels.declare import (
    SCALARS,
    ArgumentType,
    Compiled,
    CompilerError,
    KernelEntry,
    KernelError,
    dry_run,
)
from vidstyle.core.kernels.object_files import load, store
from vidstyle.core.machine.object_linker import LinkError, link
from vidstyle.core.machine.processor import described_processor
from vidstyle.core.machine.versions import version_of
from vidstyle.errors import log

COMPILER_FILES = ("arguments.py", "compiler.py", "entry_function.py", "vectors.py")
"""Files that machine code depends on, besides those of a kernel and its callees."""

_lock = threading.Lock()
_rehearsals: list[tuple[object, Callable[[], object]]] = []


@contextmanager
def rehearsing(owner: object, rehearsal: Callable[[], object]) -> Iterator[None]:
    """Within the block, a missing kernel is compiled together with all kernels that `rehearsal` calls.

    Args:
        owner: of several concurrent rehearsals of an owner, such as of all frames in flight, one is called.
        rehearsal: called in a dry run, in which kernels do nothing; its exceptions are ignored.
    """
    own = owner, rehearsal
    _rehearsals.append(own)
    try:
        yield
    finally:
        _rehearsals.remove(own)


def entry(compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> KernelEntry:
    """Return the machine code of a kernel.

    Raises:
        KernelError: it cannot be compiled for these arguments.
    """
    _check_types(compiled, kinds)
    if not _needs_plain_numba:
        try:
            # A function that is called with Python's lock, which it releases itself.
            function = ctypes.PYFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.py_object)
            return functools.partial(function(_address(compiled, kinds)), address_table(kinds))
        except KernelError:
            raise
        except (CompilerError, ImportError, AttributeError, TypeError, RuntimeError) as error:
            _use_plain_numba(error)
    return _plain_numba().entry(compiled, kinds)


def _address(compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> int:
    name = object_name(compiled, kinds)
    with _lock:
        if name in _ordered:
            code = None
        elif (code := load(name)) is None:
            _order_with_others(name, (compiled, kinds))
    code = code or _delivered(_ordered[name])
    with _lock:
        return _linked(name, code)


def _linked(name: str, code: bytes) -> int:
    try:
        return link(name, code)
    except LinkError:
        return int(_engine().add(name, code))


def _engine_module() -> Any:
    return importlib.import_module("vidstyle.core.kernels.engine")


@functools.cache
def _engine() -> Any:
    return _engine_module().Engine()


# --- Without Numba's private interface ---

_needs_plain_numba = False


def _use_plain_numba(error: Exception) -> None:
    """Use it from now on, and report this once."""
    global _needs_plain_numba
    if _only_stored:
        raise KernelError(str(error)) from error
    with _lock:
        if _needs_plain_numba:
            return
        _plain_numba().install()
        _needs_plain_numba = True
    reason = str(error) if isinstance(error, CompilerError) else f"{type(error).__name__}: {error}"
    log.warning(
        "kernels are slower, and compiled in each run, as Numba %s is not supported (%s); install %s",
        version_of("numba"), reason, _supported_numba(),
    )  # fmt: skip


def _plain_numba() -> Any:
    return importlib.import_module("vidstyle.core.kernels.plain_numba")


def _supported_numba() -> str:
    from importlib import metadata  # takes longer than all else here

    with suppress(metadata.PackageNotFoundError):
        return next(each for each in metadata.requires("vidstyle") or () if each.startswith("numba"))
    return "another one"


# --- Names ---


def object_name(compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> str:
    """Return a name that changes with all that the machine code depends on."""
    named = (compiled, *(kind for kind in kinds if isinstance(kind, Compiled)))
    files = (_file_digest(file) for file in sorted(set().union(*(each.source_files() for each in named))))
    parts = "\n".join([_platform(), repr((kinds, compiled.fastmath, compiled.noalias)), *files])
    return f"{compiled.function.__name__}_{hashlib.sha256(parts.encode()).hexdigest()}"


@functools.cache
def _platform() -> str:
    here = Path(__file__)
    files = (_file_digest(str(here.with_name(each))) for each in COMPILER_FILES)
    versions = version_of("numba"), version_of("llvmlite")
    processor = described_processor() or _engine_module().processor()
    return repr((processor, versions, object.__basicsize__, tuple.__basicsize__, *files))


@functools.cache
def _file_digest(file: str) -> str:
    path = Path(file)
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else file


def _check_types(compiled: Compiled, kinds: Iterable[ArgumentType]) -> None:
    for kind in kinds:
        if isinstance(kind, tuple):
            _check_types(compiled, () if is_array_type(kind) else kind)
        elif kind not in SCALARS and not isinstance(kind, Compiled):
            name = compiled.function.__name__
            raise KernelError(f"{name} takes arrays, numbers, kernels and tuples, not {kind.__name__}")


# --- Compilation ---

_only_stored = False


def use_stored_kernels_only() -> None:
    """Raise KernelError from now on where a kernel would have to be compiled."""
    global _only_stored
    _only_stored = True


_compilers = CompilerPool(load, store)
_ordered: dict[str, Future[bytes]] = {}
"""The object files that are being compiled, or have been."""


def _order_with_others(name: str, kernel: Kernel) -> None:
    """Order a kernel, then those that will be needed soon; they are compiled in parallel."""
    if _only_stored:
        raise KernelError(f"{kernel[0].function.__name__} is not compiled yet")
    missing = {name: kernel}
    for each in _needed_soon():
        other = object_name(*each)
        if other not in _ordered and load(other) is None:
            missing[other] = each
    for name, kernel in missing.items():
        _ordered[name] = Future()
        _compilers.take(name, kernel, _ordered[name])


def _needed_soon() -> list[Kernel]:
    """Return the kernels that the rehearsals call, in the order of first calls."""
    needed: dict[Kernel, None] = {}
    for rehearsal in dict(list(_rehearsals)).values():
        with dry_run() as calls, np.errstate(all="ignore"):
            try:
                rehearsal()
            except Exception as error:  # no values were computed; the real run raises it again
                log.debug("a dry run ended early: %s", error)
        needed |= calls
    return list(needed)


ANNOUNCEMENT_SECONDS = (1.0, True), (3.0, False)
"""Seconds of waiting before an announcement, and whether it is only for terminals."""
PAUSE_SECONDS = 1.0
"""Waits with a shorter pause between them are one."""


class _Wait:
    """When the present wait for kernels began, and when a kernel was last waited for."""

    began = ended = -math.inf


def _delivered(code: Future[bytes]) -> bytes:
    now = time.monotonic()
    _Wait.began = now if now - _Wait.ended > PAUSE_SECONDS else _Wait.began
    try:
        for seconds, only_on_terminal in ANNOUNCEMENT_SECONDS:
            with suppress(TimeoutError):
                return code.result(timeout=max(_Wait.began + seconds - time.monotonic(), 0))
            announce(only_on_terminal)
        return code.result()
    finally:
        _Wait.ended = time.monotonic()


@functools.cache
def announce(only_on_terminal: bool) -> None:
    """Report why there is no picture yet; in a log only after a long wait, and never as JSON."""
    what = {"only_on_terminal": only_on_terminal, "once": True, "only_for_people": True}
    log.info("preparing this style, once", extra=what)
