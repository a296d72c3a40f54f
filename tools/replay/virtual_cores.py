"""A simulation of threads on a number of cores."""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count

MAX_SLICE_SECONDS = 0.002
"""A thread gives way to a waiting one after this time."""


@dataclass(eq=False)
class Semaphore:
    """A number of permits; `waiting` threads get the next ones in their order."""

    permits: int = 0
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
    now, numbers = 0.0, count()
    ready: deque[tuple[Thread, float]] = deque()
    running: list[tuple[float, int, Thread, float]] = []
    ended = 0

    def go_on(thread: Thread) -> int:
        """Run a thread until it needs a core or a permit; return how many threads have ended."""
        going, over = deque([thread]), 0
        while going:
            each = going.popleft()
            operation = next(each, None)
            if operation is None:
                over += 1
            elif isinstance(operation, Work):
                ready.append((each, operation.seconds))
            elif isinstance(operation, Give):
                going.append(each)
                if operation.semaphore.waiting:
                    going.append(operation.semaphore.waiting.popleft())
                else:
                    operation.semaphore.permits += 1
            elif operation.semaphore.permits:
                operation.semaphore.permits -= 1
                going.append(each)
            else:
                operation.semaphore.waiting.append(each)
        return over

    for thread in threads:
        ended += go_on(thread)
    while ready or running:
        while ready and len(running) < cores:
            thread, left = ready.popleft()
            part = min(left, MAX_SLICE_SECONDS)
            heapq.heappush(running, (now + part, next(numbers), thread, left - part))
        now, _, thread, left = heapq.heappop(running)
        if left > 0:
            ready.append((thread, left))
        else:
            ended += go_on(thread)
    if ended < len(threads):
        raise RuntimeError(f"{len(threads) - ended} threads wait for each other")
    return now
