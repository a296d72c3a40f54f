"""The clock of a film that is played at its own speed."""

from __future__ import annotations

import time

LEAP_SECONDS = 10.0
"""A stamp this far from its predecessor begins a new count."""


class Pace:
    """Says when each frame is due."""

    def __init__(self) -> None:
        self._zero: float | None = None
        self._last = self._step = self._due = 0.0

    def until(self, stamp: float | None) -> float:
        """Seconds to wait until a frame with this stamp is due; 0 when it is late."""
        now = time.monotonic()
        if stamp is None:
            return 0.0
        if self._zero is None or not -1 < stamp - self._last < LEAP_SECONDS:
            self._zero = max(now, self._due + self._step) - stamp
        elif stamp > self._last:
            self._step = stamp - self._last
        self._last, self._due = stamp, self._zero + stamp
        return max(0.0, self._due - now)

    def restart(self) -> None:
        """The next stamp begins a new count, one step after the last frame."""
        self._zero = None
