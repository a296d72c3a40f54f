"""Waits for a camera's pictures outside the driver, which may hold who waits in it for ever."""

from __future__ import annotations

import contextlib
import os
import select
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

LOOK_SECONDS = 0.1
"""How often a wait looks up, in case it is to end."""
DESCRIPTORS = Path("/proc/self/fd")

WaitForFrame = Callable[[threading.Event, float], bool]
"""Whether there is something to read, within so many seconds and before the event is set."""


@contextlib.contextmanager
def noting_descriptors(path: str) -> Iterator[Callable[[], WaitForFrame | None]]:
    """Within it a device is opened by somebody who does not tell its descriptor.

    Gives:
        What returns, after that, how to wait for the device; None where the system does not tell.
    """
    before = _descriptors(path)

    def opened() -> WaitForFrame | None:
        new = _descriptors(path) - before
        return _wait_for(min(new)) if new else None

    yield opened


def _wait_for(descriptor: int) -> WaitForFrame:
    poll = select.poll()
    # A device that is gone is readable, too: the read says why.
    poll.register(descriptor, select.POLLIN | select.POLLERR | select.POLLHUP)

    def wait(stopping: threading.Event, seconds: float) -> bool:
        until = time.monotonic() + seconds
        while not stopping.is_set() and time.monotonic() < until:
            if poll.poll(LOOK_SECONDS * 1000):
                return True
        return False

    return wait


def _descriptors(path: str) -> set[int]:
    """Those of this process that are the device."""
    found = set()
    for entry in DESCRIPTORS.iterdir() if DESCRIPTORS.is_dir() else ():
        with contextlib.suppress(OSError):  # one that was closed meanwhile
            if os.fstat(int(entry.name)).st_rdev == os.stat(path).st_rdev:
                found.add(int(entry.name))
    return found
