"""The machine code of kernels: object files in the user's cache folder, and how missing ones are made."""

from __future__ import annotations

import atexit
import ctypes
import functools
import hashlib
import importlib
import logging
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from importlib import metadata
from pathlib import Path
from queue import SimpleQueue
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from vidstyle.core.bands import CORES
from vidstyle.core.kernels import SCALARS, ArgumentType, Compiled, dry_run, user_cache

Kernel = tuple[Compiled, tuple[ArgumentType, ...]]
"""A function and the kinds of its arguments."""
CompileRequest = tuple[str, str, str, tuple[ArgumentType, ...]]
"""What a compiling process is told: name of the object, module and name of the function, kinds."""

log = logging.getLogger("vidstyle")

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
        code = _stored(name)
        if code is None:
            code = _compiled_with_others((compiled, kinds))[name]
        address = _engine().add(name, code)
    return ctypes.CFUNCTYPE(ctypes.c_bool, *types)(address)


def object_name(compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> str:
    """A name that changes with all that the machine code depends on."""
    files = (_file_digest(file) for file in sorted(compiled.source_files()))
    parts = "\n".join([_platform(), repr((kinds, compiled.fastmath)), *files])
    return f"{compiled.function.__name__}_{hashlib.sha256(parts.encode()).hexdigest()[:24]}"


@functools.cache
def _platform() -> str:
    here = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    compilers = metadata.version("numba"), llvm.llvm_version_info
    return repr((*here, *compilers, _file_digest(str(Path(__file__).with_name("kernel_compiler.py")))))


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
        else:
            name = compiled.function.__name__
            raise TypeError(f"{name} takes arrays, numbers and tuples, not {kind.__name__}")
    return types


# --- Object files ---


def _file(name: str) -> Path:
    return user_cache() / "kernels" / f"{name}.o"


def _stored(name: str) -> bytes | None:
    try:
        return _file(name).read_bytes()
    except OSError:
        return None


def _store(name: str, code: bytes) -> None:
    """Best effort: where nothing may be written, kernels are compiled each time."""
    file = _file(name)
    unfinished = file.with_suffix(f".{os.getpid()}")
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        try:
            unfinished.write_bytes(code)
            unfinished.replace(file)
        finally:
            unfinished.unlink(missing_ok=True)


class _Engine:
    """Links object files into this process."""

    def __init__(self) -> None:
        llvm.initialize_native_target()
        llvm.initialize_native_asmprinter()
        self._machine = llvm.Target.from_default_triple().create_target_machine(jit=True)
        self._engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), self._machine)

    def add(self, name: str, code: bytes) -> int:
        self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
        self._engine.finalize_object()
        return int(self._engine.get_function_address(name))


_engine = functools.cache(_Engine)


# --- Compilation ---


def _compiled_with_others(kernel: Kernel) -> dict[str, bytes]:
    """The object files of a kernel and of what will be needed soon, compiled side by side, and stored."""
    notice = threading.Timer(1, announce)
    notice.daemon = True
    notice.start()
    try:
        jobs = {object_name(*each): each for each in (kernel, *_needed_soon())}
        missing = {name: each for name, each in jobs.items() if each == kernel or not _file(name).exists()}
        objects = _compile_side_by_side(missing)
    finally:
        notice.cancel()
    for name, code in objects.items():
        _store(name, code)
    return objects


def announce() -> None:
    """Only on a terminal, where somebody waits."""
    log.info("preparing kernels for this processor, once", extra={"only_on_terminal": True})


def _needed_soon() -> set[Kernel]:
    needed: set[Kernel] = set()
    for rehearsal in list(_rehearsals):
        with dry_run() as calls, np.errstate(all="ignore"):
            try:
                rehearsal()
            except Exception as error:  # nothing was computed in it; the real run will tell
                log.debug("a dry run ended early: %s", error)
        needed |= calls
    return needed


def _compile_side_by_side(kernels: dict[str, Kernel]) -> dict[str, bytes]:
    """Compile in a process for each core, as Numba compiles one function at a time; longest ones first."""
    longest_first = sorted(kernels, key=lambda name: kernels[name][0].length(), reverse=True)
    objects = _processes.compile([_request(name, *kernels[name]) for name in longest_first])
    for name in kernels.keys() - objects.keys():
        compiler: Any = importlib.import_module("vidstyle.core.kernel_compiler")
        objects[name] = compiler.object_code(name, *kernels[name])
    return objects


def _request(name: str, compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> CompileRequest:
    return name, compiled.function.__module__, compiled.function.__qualname__, kinds


class _Processes:
    """Processes that compile; they end when there is nothing more to do for a while."""

    IDLE = 30.0
    """Seconds after which they end."""

    def __init__(self) -> None:
        self._running: list[subprocess.Popen[bytes]] = []
        self._free: SimpleQueue[subprocess.Popen[bytes]] = SimpleQueue()
        self._busy = threading.RLock()
        self._end = threading.Timer(0, self.close)
        atexit.register(self.close)

    def compile(self, requests: Iterable[CompileRequest]) -> dict[str, bytes]:
        """The object files of these kernels.

        A script is not imported a second time, as that could run it: its own kernels are left out, and
        everything where no process can be started, as in a program that embeds Python.
        """
        jobs = [request for request in requests if request[1] != "__main__"]
        with self._busy:
            self._end.cancel()
            try:
                while len(self._running) < min(CORES, len(jobs)):
                    self._running.append(self._start())
                    self._free.put(self._running[-1])
                with ThreadPoolExecutor(CORES) as pool:
                    codes = list(pool.map(self._exchange, jobs))
            except (OSError, EOFError) as error:
                log.debug("kernels are compiled in this process: %s", error)
                self.close()
                return {}
            self._end = threading.Timer(self.IDLE, self.close)
            self._end.daemon = True
            self._end.start()
        return {name: code for (name, *_), code in zip(jobs, codes, strict=True)}

    def close(self) -> None:
        """End the processes."""
        with self._busy:
            self._end.cancel()
            self._free = SimpleQueue()
            while self._running:
                process = self._running.pop()
                assert process.stdin and process.stdout
                with suppress(OSError):
                    process.stdin.close()
                process.stdout.close()
                process.wait()

    def _start(self) -> subprocess.Popen[bytes]:
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
        command = [sys.executable, "-P", "-m", "vidstyle.core.kernel_compiler"]
        pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        # In a session of its own, so that Ctrl-C ends the program, and not its compilers first.
        return subprocess.Popen(command, env=environment, start_new_session=True, **pipes)

    def _exchange(self, request: CompileRequest) -> bytes:
        process = self._free.get()
        assert process.stdin and process.stdout
        try:
            pickle.dump(request, process.stdin)
            process.stdin.flush()
            code: bytes = pickle.load(process.stdout)
        finally:
            self._free.put(process)
        return code


_processes = _Processes()
