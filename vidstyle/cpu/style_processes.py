"""Processes that restyle pictures, so that they do not wait for each other's Python lock."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar

from vidstyle.core.machine.cores import THREADS_VARIABLE
from vidstyle.core.machine.free_memory import reserve_memory
from vidstyle.core.picture import Picture
from vidstyle.cpu.execute import FilmState
from vidstyle.cpu.style_process import Follow, StyleProcess, WorkerError
from vidstyle.errors import log
from vidstyle.picture_edit import Change, Kept

Answer = TypeVar("Answer")

MIN_PROCESS_THREADS = 8
"""Number of threads from which processes are faster: with fewer, the lock is seldom waited for."""
MIN_EDIT_THREADS = 4
"""Number of threads from which one process that only edits pictures is faster. The search for writing makes
many short calls, each of which gives the lock up and takes it back."""
PROCESS_BYTES = 64 << 20
"""Memory of a process without its picture; measured 40 to 60 MB."""
END_SECONDS = 2.0
"""Time for processes to end; then they are killed."""


class StyleProcesses:
    """Processes for the pictures of several threads.

    One process loads the program, prepares the first job, and forks the others, which so begin at once.

    Args:
        count: number of processes; 0, if the system starts none.
        memory: bytes that each takes.
        job: the job to prepare; others are possible later.
        change: of pictures, to be loaded too; None for none.
    """

    def __init__(self, count: int, memory: int, job: bytes, change: Change[Any] | None = None) -> None:
        self._lock = threading.Lock()
        self._starting: list[StyleProcess] = []
        self._idle: list[StyleProcess] = []
        self._busy: list[StyleProcess] = []
        self._parent: subprocess.Popen[bytes] | None = None
        self._is_killed = False
        try:
            self._starting.extend(StyleProcess() for _ in range(count))
            self._parent = _started(self._starting, job, change)
        except OSError as error:
            self._report(error)
            self._close_unused()
        for each in self._starting:
            each.begun()
        self._reserved = memory * len(self._starting)
        reserve_memory(self._reserved)

    def restyle(self, job: bytes, picture: Picture, shown: FilmState, follow: Follow) -> Picture | None:
        """Restyle a picture in a process that is free; see `StyleProcess.restyle`.

        Returns:
            The picture, or None if no process is free, or the process failed: it is then ended.
        """
        return self._ask(lambda process: process.restyle(job, picture, shown, follow))

    def make(self, change: Change[Kept], picture: Picture) -> tuple[Picture, Kept] | None:
        """Change a picture in a process that is free; see `restyle`."""
        return self._ask(lambda process: process.make(change, picture))

    def _ask(self, ask: Callable[[StyleProcess], Answer]) -> Answer | None:
        process = self._take()
        if process is None:
            return None
        result: Answer | None = None
        try:
            result = ask(process)
        except (WorkerError, EOFError, OSError) as error:
            self._report(error)
        finally:
            with self._lock:
                self._busy.remove(process)
                if result is not None:
                    self._idle.append(process)
            if result is None:
                process.close()
        return result

    def kill(self) -> None:
        """End all processes at once; pictures in progress become None."""
        self._is_killed = True
        if self._parent is not None:
            with suppress(ProcessLookupError):
                os.killpg(self._parent.pid, signal.SIGKILL)

    def close(self) -> None:
        """End all processes; no thread may use them any more."""
        with self._lock:
            if self._starting:
                self.kill()
            self._close_unused()
        if self._parent is not None:
            try:
                self._parent.wait(END_SECONDS)
            except subprocess.TimeoutExpired:
                self.kill()
                self._parent.wait()
        reserve_memory(-self._reserved)

    def _close_unused(self) -> None:
        for each in [*self._starting, *self._idle]:
            each.close()
        self._starting, self._idle = [], []

    def _take(self) -> StyleProcess | None:
        with self._lock:
            if not self._idle:
                self._idle = [each for each in self._starting if each.has_news and self._is_ready(each)]
            if not self._idle:
                return None
            self._busy.append(self._idle.pop())
            return self._busy[-1]

    def _is_ready(self, process: StyleProcess) -> bool:
        """Whether a process that has sent a message, or has ended, can be used."""
        self._starting = [each for each in self._starting if each is not process]
        try:
            process.wait_until_ready()
        except (EOFError, OSError) as error:
            self._report(error)
            process.close()
            return False
        return True

    def _report(self, error: Exception) -> None:
        if not self._is_killed:
            reason = str(error) or "it has ended"
            log.info(
                "a process for frames failed (%s); threads restyle its frames", reason, extra={"once": True}
            )


def _started(
    processes: list[StyleProcess], job: bytes, change: Change[Any] | None
) -> subprocess.Popen[bytes]:
    """Start a process that forks these."""
    prepared = os.memfd_create("vidstyle-job")
    try:
        with open(prepared, "wb", closefd=False) as file:
            pickle.dump((job, change), file)
        descriptors = prepared, *(each for process in processes for each in process.descriptors)
        command = [sys.executable, "-P", "-m", "vidstyle.cpu.style_worker", *map(str, descriptors)]
        path = os.pathsep.join(each or os.curdir for each in sys.path)
        silent: Any = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
        # In a separate session, so that Ctrl-C only reaches the program, which ends its processes.
        return subprocess.Popen(
            command,
            env=os.environ | {"PYTHONPATH": path, THREADS_VARIABLE: "1"},
            pass_fds=descriptors,
            start_new_session=True,
            **silent,
        )
    finally:
        os.close(prepared)


_lock = threading.Lock()
_shared: StyleProcesses | None = None
_users = 0


def borrow_processes(count: int, memory: int, job: bytes, change: Change[Any] | None) -> StyleProcesses:
    """Return the processes that all renderers of this program share; call `return_processes` at the end.

    Args:
        count, memory, job, change: see `StyleProcesses`, if there are none yet.
    """
    global _shared, _users
    with _lock:
        _shared = _shared or StyleProcesses(count, memory, job, change)
        _users += 1
        return _shared


def return_processes() -> None:
    """End the processes if no other renderer uses them."""
    global _shared, _users
    with _lock:
        _users -= 1
        if not _users and _shared is not None:
            _shared.close()
            _shared = None


def useful_processes(threads: int) -> int:
    """Return the number of processes for this number of threads: the others decode, stabilize and encode.

    On 16 cores, 12 processes are as fast as 16.

    >>> [useful_processes(threads) for threads in (2, 4, 8, 16)]
    [0, 1, 6, 12]
    """
    return threads * 3 // 4 if threads >= MIN_PROCESS_THREADS else int(threads >= MIN_EDIT_THREADS)


def can_share_pictures() -> bool:
    """Whether this system has anonymous memory that is shared by its descriptor: Linux.

    Named shared memory has a limit of 64 MB in many containers.
    """
    return hasattr(os, "memfd_create")
