"""The time that capture and live sessions go by."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable


class Clock:
    """Monotonic time in seconds, and waiting by it; tests replace it by one that they set themselves."""

    def now(self) -> float:
        """The present time, comparable with `time.monotonic`."""
        return time.monotonic()

    def wall(self) -> float:
        """The time of day, in seconds since 1970."""
        return time.time()

    def wait(self, event: threading.Event, seconds: float) -> bool:
        """Wait for an event, at most for this time; returns whether it is set."""
        return event.wait(seconds)

    def wait_for(
        self, condition: threading.Condition, predicate: Callable[[], bool], seconds: float | None
    ) -> bool:
        """`Condition.wait_for`; the caller holds the condition."""
        return condition.wait_for(predicate, seconds)


MONOTONIC = Clock()
"""The clock of real time."""
