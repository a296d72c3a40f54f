"""The latency and rate of the frames of a live session."""

from __future__ import annotations

import threading
from bisect import bisect_left
from collections import deque
from collections.abc import Sequence
from itertools import accumulate

from vidstyle.media.capture.monotonic import MONOTONIC, Clock

BIN_MS = 0.1
"""Width of a bin of the latency histogram, in milliseconds."""
MAX_MS = 5000
"""Longer latencies fall into the last bin, so that memory does not grow with the session."""
RECENT_SECONDS = 3.0
"""Window of the recent latency and of the rate."""
MAX_RECENT = 512


class LatencyMeter:
    """A histogram of latencies from capture to delivery, by a clock, and the rate of frames; thread-safe."""

    def __init__(self, clock: Clock = MONOTONIC) -> None:
        self.clock = clock
        self._counts = [0] * round(MAX_MS / BIN_MS)
        self._recent: deque[tuple[float, float]] = deque(maxlen=MAX_RECENT)
        self._lock = threading.Lock()

    def record(self, captured: float) -> None:
        """Record that a frame which was captured at this time is delivered now."""
        now = self.clock.now()
        milliseconds = max(0.0, (now - captured) * 1000)
        with self._lock:
            self._counts[min(int(milliseconds / BIN_MS), len(self._counts) - 1)] += 1
            self._recent.append((now, milliseconds))

    def latency(self) -> tuple[float, float]:
        """Median and 99th percentile in ms, of all frames; 0 before the first."""
        with self._lock:
            return _quantile(self._counts, 0.5), _quantile(self._counts, 0.99)

    def recent_latency(self) -> tuple[float, float]:
        """Median and 99th percentile in ms, of the last seconds."""
        values = sorted(value for _, value in self._last_seconds())
        if not values:
            return 0.0, 0.0
        return values[len(values) // 2], values[min(int(len(values) * 0.99), len(values) - 1)]

    @property
    def rate(self) -> float:
        """Frames per second, over the last seconds."""
        times = [time for time, _ in self._last_seconds()]
        return (len(times) - 1) / (times[-1] - times[0]) if len(times) > 1 and times[-1] > times[0] else 0.0

    def _last_seconds(self) -> list[tuple[float, float]]:
        earliest = self.clock.now() - RECENT_SECONDS
        with self._lock:
            return [each for each in self._recent if each[0] >= earliest]


def _quantile(counts: Sequence[int], share: float) -> float:
    """The centre of the bin in which this quantile lies."""
    totals = list(accumulate(counts))
    return (bisect_left(totals, share * totals[-1]) + 0.5) * BIN_MS if totals[-1] else 0.0
