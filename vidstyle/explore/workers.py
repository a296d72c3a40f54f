"""A process pool with priorities."""

from __future__ import annotations

import heapq
import os
import signal
import threading
from collections.abc import Callable
from concurrent.futures import Future, ProcessPoolExecutor
from itertools import count
from multiprocessing import connection, get_context, parent_process
from typing import Any, TypeVar

from vidstyle.core.closing import Closing
from vidstyle.core.machine.cores import available_cores

T = TypeVar("T")


class _Task(Future[Any]):
    """A waiting or running task."""

    def __init__(self, function: Callable[..., Any], arguments: tuple[Any, ...]) -> None:
        super().__init__()
        self.call = (function, *arguments)


class Workers(Closing):
    """A pool with one process per core. Running tasks are not interrupted.

    Functions, arguments and results are pickled.
    """

    def __init__(self, processes: int | None = None) -> None:
        processes = processes or available_cores()
        # Forking a program with threads may leave locks held.
        self._pool = ProcessPoolExecutor(processes, get_context("spawn"), _prepare)
        self._free, self._order, self._lock = processes, count(), threading.Lock()
        self._waiting: list[tuple[int, int, _Task]] = []

    def submit(self, urgency: int, function: Callable[..., T], *arguments: object) -> Future[T]:
        """Run a function in a process; cancel the returned future to drop the task.

        Args:
            urgency: lower numbers run first; equal numbers run in order.
        """
        task = _Task(function, arguments)
        self.hurry(task, urgency)
        return task

    def hurry(self, task: Future[Any], urgency: int) -> None:
        """Raise the priority of a waiting task."""
        assert isinstance(task, _Task)
        with self._lock:
            heapq.heappush(self._waiting, (urgency, next(self._order), task))
        self._begin()

    def close(self) -> None:
        """Cancel waiting tasks, and end the processes after their current tasks."""
        with self._lock:
            waiting, self._waiting = self._waiting, []
        for _, _, task in waiting:
            task.cancel()
        self._pool.shutdown(cancel_futures=True)

    def _begin(self) -> None:
        """Start waiting tasks in free processes."""
        while (task := self._next()) is not None:
            try:
                running = self._pool.submit(*task.call)
            except RuntimeError as error:  # closed meanwhile
                task.set_exception(error)
                return
            running.add_done_callback(lambda done, task=task: self._end(done, task))  # type: ignore[misc]

    def _next(self) -> _Task | None:
        with self._lock:
            while self._free and self._waiting:
                task = heapq.heappop(self._waiting)[2]
                # A hurried task is in the queue twice.
                if not task.running() and not task.done() and task.set_running_or_notify_cancel():
                    self._free -= 1
                    return task
        return None

    def _end(self, done: Future[Any], task: _Task) -> None:
        with self._lock:
            self._free += 1
        if done.cancelled():
            task.set_exception(RuntimeError("the workers were closed"))
        elif error := done.exception():
            task.set_exception(error)
        else:
            task.set_result(done.result())
        self._begin()


def _prepare() -> None:
    """Ignore Ctrl-C, which the main process handles; exit when the main process ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, name="vidstyle parent", daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    connection.wait([parent.sentinel])
    os._exit(1)
