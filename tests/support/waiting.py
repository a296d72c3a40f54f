"""Waiting for what comes to be. Nothing else in the tests looks at a clock, or sleeps (test_names.py)."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections import Counter
from collections.abc import Callable

from vidstyle.core.machine.cores import available_cores

IDLE_LIMIT_SECONDS = 60.0
"""Time after which a test is taken to hang. No measure: far more than anything takes on an idle machine."""


def patience() -> float:
    """IDLE_LIMIT_SECONDS, times the number of processes that share a core: each gets that much less of it."""
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else 0.0
    return IDLE_LIMIT_SECONDS * max(1.0, load / available_cores())


LONG = patience()
"""As above, when the tests began."""


def guard(what: object = "") -> Callable[[], float]:
    """A function that gives the seconds left of our patience, and fails the test once there are none."""
    begin = time.monotonic()

    def left() -> float:
        seconds = begin + patience() - time.monotonic()
        assert seconds > 0, what() if callable(what) else what or "it never came to be"
        return seconds

    return left


def eventually(fact: Callable[[], object], what: object = "") -> None:
    """Wait until something is so; fail, saying `what`, if that never comes."""
    left = guard(what)
    while not fact():
        left()
        time.sleep(0.002)


def thread_names() -> Counter[str]:
    """The names of all threads, and how many have each."""
    return Counter(thread.name for thread in threading.enumerate())


def new_threads(before: Counter[str]) -> set[str]:
    """The names of threads started since, other than further workers of a renderer's pool.

    A pool has a worker for each core and starts the next one when all others have work.
    """
    further_workers = {f"vidstyle-cpu_{number}" for number in range(1, available_cores())}
    return set(thread_names() - before) - further_workers


def is_waiting(thread: threading.Thread) -> bool:
    """Whether a thread waits for an event, a condition or a lock of Python's."""
    frame = sys._current_frames().get(thread.ident or 0)
    return frame is not None and (frame.f_code.co_filename, frame.f_code.co_name) == (
        threading.__file__,
        "wait",
    )
