"""How long frames take from capture to delivery, and how many there are."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Sequence

STEP_MS = 0.1
MAX_MS = 5000
"""Longer ones are counted as this: the count of a whole day takes no more room than that of a minute."""
RECENT_SECONDS = 3.0
MAX_RECENT = 512


class Meter:
    """Latencies of one session; from any thread."""

    def __init__(self) -> None:
        self._counts = [0] * round(MAX_MS / STEP_MS)
        self._recent: deque[tuple[float, float]] = deque(maxlen=MAX_RECENT)
        self._lock = threading.Lock()

    def delivered(self, captured: float) -> None:
        """A frame that was captured then is delivered now."""
        now = time.monotonic()
        milliseconds = max(0.0, (now - captured) * 1000)
        with self._lock:
            self._counts[min(int(milliseconds / STEP_MS), len(self._counts) - 1)] += 1
            self._recent.append((now, milliseconds))

    def latency(self) -> tuple[float, float]:
        """Median and 99th percentile in ms, of all; 0 before the first."""
        with self._lock:
            return _share(self._counts, 0.5), _share(self._counts, 0.99)

    def recent_latency(self) -> tuple[float, float]:
        """The same of the last seconds."""
        values = sorted(value for _, value in self._last())
        if not values:
            return 0.0, 0.0
        return values[len(values) // 2], values[min(int(len(values) * 0.99), len(values) - 1)]

    def _last(self) -> list[tuple[float, float]]:
        earliest = time.monotonic() - RECENT_SECONDS
        with self._lock:
            return [each for each in self._recent if each[0] >= earliest]


class RateMeter:
    """Events a second, over the last seconds."""

    def __init__(self) -> None:
        self._times: deque[float] = deque(maxlen=MAX_RECENT)

    def count(self) -> None:
        """One now."""
        self._times.append(time.monotonic())

    @property
    def now(self) -> float:
        """A second."""
        earliest = time.monotonic() - RECENT_SECONDS
        times = [each for each in self._times.copy() if each >= earliest]
        return (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 and times[-1] > times[0] else 0.0


def _share(counts: Sequence[int], share: float) -> float:
    """The latency below which this share of all lies, by the middle of its step."""
    wanted, seen = share * sum(counts), 0
    for place, count in enumerate(counts):
        seen += count
        if count and seen >= wanted:
            return (place + 0.5) * STEP_MS
    return 0.0
