"""The machine code of kernels: object files in the user's cache folder, and how missing ones are made."""

from __future__ import annotations

import ctypes
import functools
import hashlib
import importlib
import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any

import llvmlite.binding as llvm
import numpy as np

from vidstyle.core.bands import CORES
from vidstyle.core.installed import version_of
from vidstyle.core.kernels import SCALARS, ArgumentType, Compiled, dry_run, user_cache
from vidstyle.errors import log

Kernel = tuple[Compiled, tuple[ArgumentType, ...]]
"""A function and the types of its arguments."""
CompileRequest = tuple[str, str, str, tuple[ArgumentType, ...]]
"""What a compiling process is told: name of the object, module and name of the function, types."""


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
        elif (code := _stored(name)) is None:
            _order_with_others(name, (compiled, kinds))
    code = code or _delivered(_ordered[name])
    with _lock:
        address = _engine().add(name, code)
    return ctypes.CFUNCTYPE(ctypes.c_bool, *types)(address)


def object_name(compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> str:
    """A name that changes with all that the machine code depends on."""
    files = (_file_digest(file) for file in sorted(compiled.source_files()))
    parts = "\n".join([_platform(), repr((kinds, compiled.fastmath, compiled.noalias)), *files])
    return f"{compiled.function.__name__}_{hashlib.sha256(parts.encode()).hexdigest()[:24]}"


@functools.cache
def _platform() -> str:
    here = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    compilers = version_of("numba"), llvm.llvm_version_info
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
        self._added: set[str] = set()

    def add(self, name: str, code: bytes) -> int:
        if name not in self._added:
            self._engine.add_object_file(llvm.ObjectFileRef.from_data(code))
            self._engine.finalize_object()
            self._added.add(name)
        return int(self._engine.get_function_address(name))


_engine = functools.cache(_Engine)


# --- Compilation ---

_ordered: dict[str, Future[bytes]] = {}
"""The object files that are being compiled, or have been."""


def _order_with_others(name: str, kernel: Kernel) -> None:
    """Have a kernel compiled, and then what will be needed soon, side by side."""
    missing = {name: kernel}
    for each in _needed_soon():
        other = object_name(*each)
        if other not in _ordered and not _file(other).exists():
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


class _Compilers:
    """Threads that compile, each in a process of its own, as Numba compiles one function at a time.

    They end when there is nothing to do for a while; as daemons they keep no program from ending.
    """

    IDLE = 30.0
    """Seconds after which they end."""

    def __init__(self) -> None:
        self._jobs: SimpleQueue[tuple[str, Kernel, Future[bytes]]] = SimpleQueue()
        self._running = 0
        self._lock = threading.Lock()

    def take(self, name: str, kernel: Kernel, code: Future[bytes]) -> None:
        """Compile a kernel as soon as a core is free, and store its object file."""
        with self._lock:
            self._jobs.put((name, kernel, code))
            if self._running < CORES:
                self._running += 1
                threading.Thread(target=self._run, name="kernel compiler", daemon=True).start()

    def _run(self) -> None:
        with closing(_Process()) as process:
            for name, kernel, code in iter(self._next, None):
                try:
                    object_code = process.compile(name, *kernel)
                    _store(name, object_code)
                    code.set_result(object_code)
                except Exception as error:  # raised where the kernel is called
                    code.set_exception(error)

    def _next(self) -> tuple[str, Kernel, Future[bytes]] | None:
        with suppress(Empty):
            return self._jobs.get(timeout=self.IDLE)
        with self._lock:
            with suppress(Empty):  # one that came in meanwhile
                return self._jobs.get_nowait()
            self._running -= 1
            return None


class _Process:
    """A process that compiles; started when it is needed."""

    def __init__(self) -> None:
        self._running: subprocess.Popen[bytes] | None = None

    def compile(self, name: str, compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> bytes:
        """The object file of a kernel, compiled here where no process can do it.

        None can be started in a program that embeds Python; and a script is not imported a second time, as
        that could run it.
        """
        module, function = compiled.function.__module__, compiled.function.__qualname__
        if module != "__main__":
            try:
                return self._answer((name, module, function, kinds))
            except (OSError, EOFError) as error:
                log.debug("%s is compiled in this process: %s", function, error)
                self.close()
        compiler: Any = importlib.import_module("vidstyle.core.kernel_compiler")
        code: bytes = compiler.object_code(name, compiled, kinds)
        return code

    def close(self) -> None:
        """End the process."""
        if self._running is not None:
            assert self._running.stdin and self._running.stdout
            with suppress(OSError):
                self._running.stdin.close()
            self._running.stdout.close()
            self._running.wait()
            self._running = None

    def _answer(self, request: CompileRequest) -> bytes:
        self._running = self._running or self._started()
        assert self._running.stdin and self._running.stdout
        pickle.dump(request, self._running.stdin)
        self._running.stdin.flush()
        code: bytes = pickle.load(self._running.stdout)
        return code

    @staticmethod
    def _started() -> subprocess.Popen[bytes]:
        # As an entry of sys.path "" is the working folder, where what is compiled may come from.
        path = [each or os.curdir for each in sys.path]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(path)}
        command = [sys.executable, "-P", "-m", "vidstyle.core.kernel_compiler"]
        pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        # In a session of its own, so that Ctrl-C ends the program, and not its compilers first.
        return subprocess.Popen(command, env=environment, start_new_session=True, **pipes)


_compilers = _Compilers()
