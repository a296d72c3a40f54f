"""The clock of a target that shows pictures at one rate: which is shown at which tick, which one again."""

from __future__ import annotations

from fractions import Fraction

LATE = 0.75
"""By how much of a tick a picture may miss its own, so that trembling makes none drop and none repeat."""
LONGEST_GAP = 1.0
"""After so many seconds without a write the reader itself stood still, and the count goes on from there."""


class Ticks:
    """Numbers ticks from the first picture on.

    Attributes:
        last: the number of the tick that was filled last; -1 before the first.
    """

    def __init__(self, rate: Fraction) -> None:
        self._rate = float(rate)
        self._zero: float | None = None
        self.last = -1

    def place(self, now: float) -> int | None:
        """The tick for a picture that is there now, or None if it is too early and to be left out.

        Args:
            now: in seconds of `time.monotonic`.
        """
        wanted = self.last + 1
        if self._zero is None or now - self._time(wanted) > LONGEST_GAP:
            self._zero = now - wanted / self._rate
        position = (now - self._zero) * self._rate
        if position < wanted - LATE:
            return None
        self.last = wanted if position <= wanted + LATE else round(position)
        return self.last

    def wait(self, now: float) -> float | None:
        """Seconds until the last picture must be shown again, or None if there was none yet."""
        return None if self._zero is None else max(0.0, self._time(self.last + 1 + LATE) - now)

    def _time(self, position: float) -> float:
        assert self._zero is not None
        return self._zero + position / self._rate
