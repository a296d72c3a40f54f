"""Compiles kernels in other processes, one for each core."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import closing, suppress
from queue import Empty, SimpleQueue
from typing import Any

from vidstyle.core.kernels.compiler_process import compile_here
from vidstyle.core.kernels.declare import ArgumentType, Compiled
from vidstyle.core.machine.cores import available_cores
from vidstyle.errors import log

Kernel = tuple[Compiled, tuple[ArgumentType, ...]]
"""A function and the types of its arguments."""
CompileRequest = tuple[str, str, str, tuple[ArgumentType, ...]]
"""A request to a compiler process: name of the object, module and name of the function, types."""


class CompilerPool:
    """Threads that compile, each in a separate process, as Numba compiles one function at a time.

    They end when there is nothing to do for a while; as daemons they keep no program from ending.

    Args:
        load: returns an object file by its name that another program has stored meanwhile, or None.
        store: called with the name and the bytes of each object file before it is handed out.
    """

    IDLE = 30.0
    """Seconds after which they end."""

    def __init__(self, load: Callable[[str], bytes | None], store: Callable[[str, bytes], None]) -> None:
        self._load, self._store = load, store
        self._jobs: SimpleQueue[tuple[str, Kernel, Future[bytes]]] = SimpleQueue()
        self._running = 0
        self._lock = threading.Lock()

    def take(self, name: str, kernel: Kernel, code: Future[bytes]) -> None:
        """Compile a kernel as soon as a core is free, and store its object file."""
        with self._lock:
            self._jobs.put((name, kernel, code))
            if self._running < available_cores():
                self._running += 1
                threading.Thread(target=self._run, name="kernel compiler", daemon=True).start()

    def _run(self) -> None:
        with closing(_CompilerProcess()) as process:
            for name, kernel, code in iter(self._next, None):
                try:
                    code.set_result(self._load(name) or self._compile(process, name, kernel))
                except Exception as error:  # raised where the kernel is called
                    code.set_exception(error)

    def _compile(self, process: _CompilerProcess, name: str, kernel: Kernel) -> bytes:
        object_code = process.compile(name, *kernel)
        self._store(name, object_code)
        return object_code

    def _next(self) -> tuple[str, Kernel, Future[bytes]] | None:
        with suppress(Empty):
            return self._jobs.get(timeout=self.IDLE)
        with self._lock:
            with suppress(Empty):  # one that came in meanwhile
                return self._jobs.get_nowait()
            self._running -= 1
            return None


class _CompilerProcess:
    """A process that compiles; started when it is needed."""

    def __init__(self) -> None:
        self._running: subprocess.Popen[bytes] | None = None

    def compile(self, name: str, compiled: Compiled, kinds: tuple[ArgumentType, ...]) -> bytes:
        """Return the object file of a kernel, compiled here where no process can do it.

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
        return compile_here(name, compiled, kinds)

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
        answer: bytes | Exception = pickle.load(self._running.stdout)
        if isinstance(answer, Exception):
            raise answer
        return answer

    @staticmethod
    def _started() -> subprocess.Popen[bytes]:
        # The entry "" of sys.path is the working folder, which may contain the kernels.
        path = [each or os.curdir for each in sys.path]
        environment = os.environ | {"PYTHONPATH": os.pathsep.join(path)}
        command = [sys.executable, "-P", "-m", "vidstyle.core.kernels.compiler_process"]
        pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.DEVNULL}
        # In a separate session, so that Ctrl-C ends the program before its compilers.
        return subprocess.Popen(command, env=environment, start_new_session=True, **pipes)
