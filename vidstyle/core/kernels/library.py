"""The machine code of kernels: object files in the user's cache folder, and how missing ones are made."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from vidstyle.core.installed import version_of
from vidstyle.core.kernels.compiler_pool import CompilerPool, Kernel
from vidstyle.core.kernels.declare import SCALARS, ArgumentType, Compiled, dry_run
from vidstyle.core.kernels.object_files import load, store
from vidstyle.errors import log

_lock = threading.Lock()
_rehearsals: list[Callable[[], object]] = []


@contextmanager
def rehearsing(rehearsal: Callable[[], object]) -> Iterator[None]:
    """Within it, when a kernel is missing, all that `rehearsal` calls are compiled along with it.

    Args:
        rehearsal: called in a dry run, in which kernels do nothing; what it raises there does not matter.
    """
    _rehearsals.append(rehearsal)
    try:
        yield
    finally:
        _rehearsals.remove(rehearsal)


def entry(compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> Callable[..., object]:
    """The machine code of a kernel; it takes the flattened arguments."""
    name, types = object_name(compiled, kinds), _c_types(compiled, kinds)
    with _lock:
        if name in _ordered:
            code = None
        elif (code := load(name)) is None:
            _order_with_others(name, (compiled, kinds))
    code = code or _delivered(_ordered[name])
    with _lock:
        address = _engine().add(name, code)
    return ctypes.CFUNCTYPE(ctypes.c_bool, *types)(address)


def object_name(compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> str:
    """A name that changes with all that the machine code depends on."""
    named = (compiled, *(kind for kind in kinds if isinstance(kind, Compiled)))
    files = (_file_digest(file) for file in sorted(set().union(*(each.source_files() for each in named))))
    parts = "\n".join([_platform(), repr((kinds, compiled.fastmath, compiled.noalias)), *files])
    return f"{compiled.function.__name__}_{hashlib.sha256(parts.encode()).hexdigest()}"


@functools.cache
def _platform() -> str:
    here = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten(), object.__basicsize__
    compilers = version_of("numba"), llvm.llvm_version_info
    return repr((*here, *compilers, _file_digest(str(Path(__file__).with_name("compiler.py")))))


@functools.cache
def _file_digest(file: str) -> str:
    path = Path(file)
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else file


def _c_types(compiled: Compiled, kinds: Iterable[ArgumentType]) -> list[Any]:
    """The C types of flattened arguments; an array is passed as a pointer to its Python object."""
    types: list[Any] = []
    for kind in kinds:
        if isinstance(kind, tuple) and isinstance(kind[0], np.dtype):
            types.append(ctypes.py_object)
        elif isinstance(kind, tuple):
            types += _c_types(compiled, kind)
        elif kind in SCALARS:
            types.append(SCALARS[kind])
        elif not isinstance(kind, Compiled):
            name = compiled.function.__name__
            raise TypeError(f"{name} takes arrays, numbers, kernels and tuples, not {kind.__name__}")
    return types


class _Engine:
    """Links object files into this process."""

    def __init__(self) -> None:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        self._machine = llvm.Target.from_default_triple().create_target_machine(jit=True)
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), self._machine)
        self._added: set[str] = set()

    def add(self, name: str, code: bytes) -> int:
        if name not in self._added:
            self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
            self._engine.finalize_object()
            self._added.add(name)
        return int(self._engine.get_function_address(name))


_engine = functools.cache(_Engine)


# --- Compilation ---

_compilers = CompilerPool(store)
_ordered: dict[str, Future[bytes]] = {}
"""The object files that are being compiled, or have been."""


def _order_with_others(name: str, kernel: Kernel) -> None:
    """Have a kernel compiled, and then what will be needed soon, side by side."""
    missing = {name: kernel}
    for each in _needed_soon():
        other = object_name(*each)
        if other not in _ordered and load(other) is None:
            missing[other] = each
    for name, kernel in missing.items():
        _ordered[name] = Future()
        _compilers.take(name, kernel, _ordered[name])


def _needed_soon() -> list[Kernel]:
    """What the rehearsals call, in the order of first calls."""
    needed: dict[Kernel, None] = {}
    for rehearsal in list(_rehearsals):
        with dry_run() as calls, np.errstate(all="ignore"):
            try:
                rehearsal()
            except Exception as error:  # nothing was computed in it; the real run will tell
                log.debug("a dry run ended early: %s", error)
        needed |= calls
    return list(needed)


def _delivered(code: Future[bytes]) -> bytes:
    try:
        return code.result(timeout=1)
    except TimeoutError:
        announce()
    return code.result()


def announce() -> None:
    """Only on a terminal, where somebody waits."""
    what = {"only_on_terminal": True, "once": True}
    log.info("preparing kernels, once for each style", extra=what)
