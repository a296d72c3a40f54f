"""Processes that restyle pictures, so that they do not wait for each other's Python lock."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np

from vidstyle.core.machine.cores import THREADS_VARIABLE
from vidstyle.core.machine.free_memory import reserve_memory
from vidstyle.core.picture import Picture
from vidstyle.cpu.shared_pictures import SharedPictures
from vidstyle.errors import log
from vidstyle.style.nodes import StepKey

MIN_PROCESS_THREADS = 8
"""Number of threads from which processes are faster: with fewer, the lock is seldom waited for."""
PROCESS_START_FRAMES = 48
"""Frame of a film at which the processes start; shorter films would end before the processes pay."""
PROCESS_BYTES = 64 << 20
"""Memory of a process in addition to that of a picture; measured 40 to 60 MB."""
END_SECONDS = 2.0
"""Time for an ended process to be reaped."""

Follow = Callable[[StepKey, float, np.ndarray], np.ndarray]
"""Takes a measured step, its time constant and its percentiles; returns the smoothed ones."""


class WorkerError(Exception):
    """A process could not restyle a picture."""


class StyleProcess:
    """A process that restyles one picture at a time, with one thread.

    It ends when this process ends, as its connection is then closed.
    """

    def __init__(self) -> None:
        from multiprocessing.connection import Connection  # seldom needed

        self._pictures = SharedPictures(os.memfd_create("vidstyle"))
        ours, theirs = socket.socketpair()
        descriptors = theirs.fileno(), self._pictures.descriptor
        command = [sys.executable, "-P", "-m", "vidstyle.cpu.style_worker", *map(str, descriptors)]
        path = os.pathsep.join(each or os.curdir for each in sys.path)
        silent: Any = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
        self._connection = Connection(ours.detach())
        try:
            # In a separate session, so that Ctrl-C only reaches the program, which ends its processes.
            self._process = subprocess.Popen(
                command,
                env=os.environ | {"PYTHONPATH": path, THREADS_VARIABLE: "1"},
                pass_fds=descriptors,
                start_new_session=True,
                **silent,
            )
        except OSError:
            self._release()
            raise
        finally:
            theirs.close()

    @property
    def has_news(self) -> bool:
        """Whether it has sent a message, or has ended."""
        return self._connection.poll()

    def wait_until_ready(self) -> None:
        """Wait for its first message.

        Raises:
            EOFError, OSError: it has ended.
        """
        self._connection.recv()

    def restyle(self, job: bytes, picture: Picture, moment: int, follow: Follow) -> Picture:
        """Restyle a picture.

        Args:
            job: a pickled `StyleJob`.
            moment: `FrameTime` of the frame.

        Raises:
            WorkerError: it cannot restyle the picture.
            EOFError, OSError: it has ended.
        """
        self._connection.send((job, *self._pictures.store(picture), moment))
        while True:
            kind, *content = self._connection.recv()
            if kind == "picture":
                return self._pictures.load(content[0]).map_planes(lambda plane, _: plane.copy())
            if kind == "error":
                raise WorkerError(content[0])
            self._connection.send(follow(*content))

    def kill(self) -> None:
        """End it at once; a thread that waits for it gets an EOFError."""
        self._process.kill()

    def close(self) -> None:
        """End it, and release its memory; no thread may wait for it."""
        self.kill()
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(END_SECONDS)
        self._release()

    def _release(self) -> None:
        self._connection.close()
        os.close(self._pictures.descriptor)


class StyleProcesses:
    """Processes for the pictures of several threads.

    Args:
        count: number of processes; fewer, if the system starts no more.
        memory: bytes that each takes.
    """

    def __init__(self, count: int, memory: int) -> None:
        self._lock = threading.Lock()
        self._starting: list[StyleProcess] = []
        self._idle: list[StyleProcess] = []
        self._busy: list[StyleProcess] = []
        try:
            self._starting.extend(StyleProcess() for _ in range(count))
        except OSError as error:
            log.debug("no more processes for pictures: %s", error)
        self._reserved = memory * len(self._starting)
        reserve_memory(self._reserved)

    def restyle(self, job: bytes, picture: Picture, moment: int, follow: Follow) -> Picture | None:
        """Restyle a picture in a process that is free; see `StyleProcess.restyle`.

        Returns:
            The picture, or None if no process is free, or the process failed: it is then ended.
        """
        process = self._take()
        if process is None:
            return None
        result: Picture | None = None
        try:
            result = process.restyle(job, picture, moment, follow)
        except (WorkerError, EOFError, OSError) as error:
            log.debug("a process for pictures ended: %r", error)
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
        with self._lock:
            for each in [*self._starting, *self._idle, *self._busy]:
                each.kill()

    def close(self) -> None:
        """End all processes; no thread may use them any more."""
        with self._lock:
            unused = [*self._starting, *self._idle]
            self._starting, self._idle = [], []
        for each in unused:
            each.close()
        reserve_memory(-self._reserved)

    def _take(self) -> StyleProcess | None:
        with self._lock:
            if not self._idle:
                self._idle = [each for each in self._starting if each.has_news and self._started(each)]
            if not self._idle:
                return None
            self._busy.append(self._idle.pop())
            return self._busy[-1]

    def _started(self, process: StyleProcess) -> bool:
        """Whether a process that has sent a message, or has ended, can be used."""
        self._starting = [each for each in self._starting if each is not process]
        try:
            process.wait_until_ready()
        except (EOFError, OSError):
            process.close()
            return False
        return True


_lock = threading.Lock()
_shared: StyleProcesses | None = None
_users = 0


def borrow_processes(count: int, memory: int) -> StyleProcesses:
    """Return the processes that all renderers of this program share; call `return_processes` at the end.

    Args:
        count, memory: see `StyleProcesses`, if there are none yet.
    """
    global _shared, _users
    with _lock:
        _shared = _shared or StyleProcesses(count, memory)
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

    On 16 cores, 12 processes are as fast as 16, and start sooner.

    >>> [useful_processes(threads) for threads in (8, 16)]
    [6, 12]
    """
    return threads * 3 // 4


def can_share_pictures() -> bool:
    """Whether this system has anonymous memory that is shared by its descriptor: Linux.

    Named shared memory has a limit of 64 MB in many containers.
    """
    return hasattr(os, "memfd_create")
