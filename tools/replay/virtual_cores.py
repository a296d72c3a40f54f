"""Simulate threads on a number of cores."""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count

MAX_SLICE_SECONDS = 0.002
"""Time slice after which a thread yields to a waiting one."""


@dataclass(eq=False)
class Semaphore:
    """A semaphore; waiting threads get permits in order.

    Attributes:
        wake_up_seconds: time until a waiting thread can take a returned permit; until then, a thread that
            does not wait may take it. With 0, the waiting thread gets it immediately.
    """

    permits: int = 0
    wake_up_seconds: float = 0.0
    waiting: deque[Thread] = field(default_factory=deque)


@dataclass(frozen=True)
class Work:
    """Occupies a core for a time."""

    seconds: float


@dataclass(frozen=True)
class Take:
    """Waits for a permit."""

    semaphore: Semaphore


@dataclass(frozen=True)
class Give:
    """Returns a permit."""

    semaphore: Semaphore


Operation = Work | Take | Give
Thread = Iterator[Operation]


def run(threads: list[Thread], cores: int) -> float:
    """Return the seconds until all threads have ended.

    Raises:
        RuntimeError: some threads wait for each other.
    """
    machine = _Machine(cores)
    for thread in threads:
        machine.advance(thread)
    machine.run()
    if machine.ended < len(threads):
        raise RuntimeError(f"{len(threads) - machine.ended} threads wait for each other")
    return machine.now


class _Machine:
    """State of the threads: `ready` threads wait for a core, `busy` threads have one or are waking up."""

    def __init__(self, cores: int) -> None:
        self.now, self.ended = 0.0, 0
        self._free, self._numbers = cores, count()
        self._ready: deque[tuple[Thread, float]] = deque()
        self._busy: list[tuple[float, int, Thread, float | Semaphore]] = []

    def run(self) -> None:
        while self._ready or self._busy:
            while self._ready and self._free:
                thread, seconds = self._ready.popleft()
                self._free -= 1
                part = min(seconds, MAX_SLICE_SECONDS)
                self._until(self.now + part, thread, seconds - part)
            self.now, _, thread, left = heapq.heappop(self._busy)
            if isinstance(left, Semaphore):
                self.advance(thread, Take(left))
                continue
            self._free += 1
            if left > 0:
                self._ready.append((thread, left))
            else:
                self.advance(thread)

    def _until(self, moment: float, thread: Thread, left: float | Semaphore) -> None:
        heapq.heappush(self._busy, (moment, next(self._numbers), thread, left))

    def advance(self, thread: Thread, operation: Operation | None = None) -> None:
        """Run a thread, and threads that get a permit from it, until they need a core or a permit."""
        going = deque([(thread, operation)])
        while going:
            each, operation = going.popleft()
            operation = operation or next(each, None)
            if operation is None:
                self.ended += 1
            elif isinstance(operation, Work):
                self._ready.append((each, operation.seconds))
            elif isinstance(operation, Take):
                if operation.semaphore.permits:
                    operation.semaphore.permits -= 1
                    going.append((each, None))
                else:
                    operation.semaphore.waiting.append(each)
            else:
                going.append((each, None))
                if woken := self._give(operation.semaphore):
                    going.append((woken, None))

    def _give(self, semaphore: Semaphore) -> Thread | None:
        """Return the thread that has the permit now, if any."""
        if not semaphore.waiting:
            semaphore.permits += 1
            return None
        woken = semaphore.waiting.popleft()
        if not semaphore.wake_up_seconds:
            return woken
        semaphore.permits += 1
        self._until(self.now + semaphore.wake_up_seconds, woken, semaphore)
        return None
