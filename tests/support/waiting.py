"""Wait for conditions; the only tests that read the clock or sleep use these functions (test_names.py)."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable

from vidstyle.core.machine.cores import available_cores

IDLE_LIMIT_SECONDS = 60.0
"""Time after which a test counts as hanging, far longer than any operation takes on an idle machine."""


def patience() -> float:
    """Return `IDLE_LIMIT_SECONDS`, multiplied by the number of processes per core."""
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return IDLE_LIMIT_SECONDS * max(1.0, load / available_cores())


LONG = patience()
"""Result of `patience` at the start of the tests."""


def guard(what: object = "") -> Callable[[], float]:
    """Return a function that returns the seconds left, and fails the test after a timeout."""
    begin = time.monotonic()

    def left() -> float:
        seconds = begin + patience() - time.monotonic()
        assert seconds > 0, what() if callable(what) else what or "timeout"
        return seconds

    return left


def eventually(fact: Callable[[], object], what: object = "") -> None:
    """Wait until a condition holds; fail with the message `what` after a timeout."""
    left = guard(what)
    while not fact():
        left()
        time.sleep(0.002)


def thread_names() -> Counter[str]:
    """Return the number of threads by name."""
    return Counter(thread.name for thread in threading.enumerate())


def new_threads(before: Counter[str]) -> set[str]:
    """Return the names of threads started since `before`, except further workers of a renderer's pool.

    A pool has a worker for each core and starts the next one when all others have work.
    """
    further_workers = {f"vidstyle-cpu_{number}" for number in range(1, available_cores())}
    return set(thread_names() - before) - further_workers


def is_waiting(thread: threading.Thread) -> bool:
    """Return whether a thread waits for an event, a condition or a lock."""
    frame = sys._current_frames().get(thread.ident or 0)
    return frame is not None and (frame.f_code.co_filename, frame.f_code.co_name) == (
        threading.__file__,
        "wait",
    )
