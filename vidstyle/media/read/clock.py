"""Repair timestamps, so that they strictly increase, and resample them to a constant frame rate."""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import av

from vidstyle.errors import log
from vidstyle.media.frame import DecodedFrame, Frame

MIN_TICKS_PER_SECOND = 1000
"""Ticks per second below which a time base is divided, so that a shift by one tick is invisible."""
TIME_BASE_DIVISION = 512
MAX_TERM = 2**31 - 1
"""Maximum numerator or denominator of a fraction in FFmpeg."""


def fine_time_base(time_base: Fraction) -> Fraction:
    """Return the time base, or a division of it with invisibly short ticks.

    >>> fine_time_base(Fraction(1, 30)), fine_time_base(Fraction(1, 90000))
    (Fraction(1, 15360), Fraction(1, 90000))
    """
    if 1 / time_base >= MIN_TICKS_PER_SECOND:
        return time_base
    # Within the range of FFmpeg's integers: a damaged header may contain any number.
    return time_base / min(TIME_BASE_DIVISION, MAX_TERM // time_base.denominator)


class FrameClock:
    """Assigns strictly increasing timestamps to decoded frames, in a time base fine enough for repairs.

    Attributes:
        time_base: time base of the assigned timestamps.
        step: frame interval by the frame rate, in the time base of the source.
        shifted, generated: number of timestamps that were shifted, and generated from the frame rate.
    """

    def __init__(self, time_base: Fraction, rate: Fraction, window: int = 0) -> None:
        """Start a clock.

        Args:
            time_base: time base of the source.
            rate: frames per second, for frames without timestamps.
            window: number of frames over which timestamps are sorted, for formats without presentation times.
        """
        self.time_base = fine_time_base(time_base)
        self.shifted = 0
        self.generated = 0
        self.step = 1 / (rate * time_base)
        self._scale = int(time_base / self.time_base)
        self._step = max(1, round(1 / (rate * self.time_base)))
        self._last: int | None = None
        self._window = window
        self._waiting: deque[tuple[av.VideoFrame, bool]] = deque()
        self._stamps: list[int] = []
        self._newest = 0

    def reset(self) -> None:
        """Forget the frames seen, before a seek."""
        self._last, self._newest = None, 0
        self._waiting.clear()
        self._stamps.clear()

    def push(self, native: av.VideoFrame, pts: int | None, repeated: bool = False) -> None:
        """Add a frame; `pts` is in the time base of the source, None if unknown."""
        if pts is None:
            self._warn_once(
                self.generated, "the stream has no timestamps; they are generated from its frame rate"
            )
            self.generated += 1
            stamp = self._newest + self._step if self._stamps or self._last is not None else 0
        else:
            stamp = pts * self._scale
        self._newest = stamp
        self._waiting.append((native, repeated))
        heapq.heappush(self._stamps, stamp)

    def pull(self, flush: bool = False) -> Iterator[DecodedFrame]:
        """Yield the frames whose time is certain; with `flush` all queued frames."""
        while len(self._waiting) > (0 if flush else self._window):
            stamp = heapq.heappop(self._stamps)
            if self._last is not None and stamp <= self._last:
                self._warn_once(self.shifted, "timestamps that do not increase are shifted")
                self.shifted += 1
                stamp = self._last + 1
            self._last = stamp
            native, repeated = self._waiting.popleft()
            duration = (native.duration or 0) * self._scale or None
            yield DecodedFrame(native, stamp, duration, bool(native.key_frame), repeated)

    @staticmethod
    def _warn_once(already: int, message: str) -> None:
        if not already:
            log.warning(message)


class ConstantRate:
    """Converts to a constant frame rate by dropping and repeating frames: the nearest in time is kept."""

    def __init__(self, rate: Fraction) -> None:
        self.time_base = fine_time_base(1 / rate)
        self._interval = 1 / rate
        self._ticks = round(self._interval / self.time_base)
        self._slot: int | None = None
        self._last: Frame | None = None

    def push(self, frame: Frame) -> Iterator[Frame]:
        """Yield the frames for all times that are nearer to the previous frame than to this one."""
        if self._last is None or self._slot is None:
            self._slot = round(frame.time / self._interval)
        else:
            yield from self._until((self._last.time + frame.time) / 2)
        self._last = frame

    def flush(self) -> Iterator[Frame]:
        """Yield the frames for the rest of the last frame's duration, within half an interval."""
        if self._last is None:
            return
        duration = (self._last.duration or 0) * self._last.time_base or self._interval
        yield from self._until(self._last.time + duration - self._interval / 2)

    def _until(self, end: Fraction) -> Iterator[Frame]:
        assert self._last is not None and self._slot is not None
        while self._slot * self._interval < end:
            pts = self._slot * self._ticks
            yield replace(self._last, pts=pts, time_base=self.time_base, duration=self._ticks)
            self._slot += 1
