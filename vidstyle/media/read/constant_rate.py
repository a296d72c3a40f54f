"""Converts to a constant frame rate: frames are dropped or repeated, the nearest in time is kept."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

from vidstyle.media.frame import Frame
from vidstyle.media.read.clock import fine_time_base


class ConstantRate:
    """Resamples frames in time."""

    def __init__(self, rate: Fraction) -> None:
        self.time_base = fine_time_base(1 / rate)
        self._interval = 1 / rate
        self._ticks = round(self._interval / self.time_base)
        self._slot: int | None = None
        self._last: Frame | None = None

    def push(self, frame: Frame) -> Iterator[Frame]:
        """The frames for the moments that are nearer to the frame before than to this one."""
        if self._last is None or self._slot is None:
            self._slot = round(frame.time / self._interval)
        else:
            yield from self._until((self._last.time + frame.time) / 2)
        self._last = frame

    def flush(self) -> Iterator[Frame]:
        """The frames for the rest of the last frame's time, half an interval more or less."""
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
