"""The clock of capture and live sessions."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable


class Clock:
    """Monotonic time in seconds, and waiting; tests replace it with a clock that they control."""

    def now(self) -> float:
        """Return the current time, comparable with `time.monotonic`."""
        return time.monotonic()

    def wall(self) -> float:
        """Return the time of day, in seconds since 1970."""
        return time.time()

    def wait(self, event: threading.Event, seconds: float) -> bool:
        """Wait for an event, at most for this time; return whether it is set."""
        return event.wait(seconds)

    def wait_for(
        self, condition: threading.Condition, predicate: Callable[[], bool], seconds: float | None
    ) -> bool:
        """Call `Condition.wait_for`; the caller holds the condition."""
        return condition.wait_for(predicate, seconds)


MONOTONIC = Clock()
"""The clock of real time."""
