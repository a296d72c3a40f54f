"""Time repaired: every frame gets a stamp, and stamps only grow."""

from __future__ import annotations

import heapq
import logging
from collections import deque
from collections.abc import Iterator
from fractions import Fraction
from typing import Any, Generic, TypeVar

import av

log = logging.getLogger("vidstyle")

Shown = TypeVar("Shown")

FINE = 1000
"""Ticks a second below which a time base is divided, so that a nudge by one tick is not seen."""
DIVISION = 512
RESTART = Fraction(1)
"""A stamp this many seconds before its predecessor is a new beginning, not a disorder."""
LEAP = Fraction(10)
"""In broadcast streams a leap forward by this many seconds is one, too (as in FFmpeg's own program)."""
BROADCAST = frozenset({"mpegts", "mpeg", "rtsp", "rtp"})
"""Formats whose clock starts anywhere and may jump."""
NEAR_ZERO = Fraction(1)
"""A film that starts within this many seconds of zero keeps its start."""


def fine_time_base(time_base: Fraction) -> Fraction:
    """The time base itself, or a division of it with ticks too short to be seen.

    >>> fine_time_base(Fraction(1, 30)), fine_time_base(Fraction(1, 90000))
    (Fraction(1, 15360), Fraction(1, 90000))
    """
    return time_base / DIVISION if 1 / time_base < FINE else time_base


def start_shift(container: av.container.InputContainer) -> Fraction:
    """The seconds to take off every stamp, so that a broadcast recording begins at zero."""
    start = Fraction(container.start_time or 0, av.time_base)
    names = set(container.format.name.split(","))
    return start if names & BROADCAST or abs(start) >= NEAR_ZERO else Fraction(0)


class PacketClock:
    """Moves the stamps of packets by the same time in all streams, and bridges jumps of their clock.

    Attributes:
        shift: seconds that are taken off every stamp just now.
    """

    def __init__(self, shift: Fraction, broadcast: bool) -> None:
        self.shift = shift
        self._leaps = broadcast
        self._expected: dict[int, Fraction] = {}
        self.jumps = 0

    def restamp(self, packet: av.Packet) -> None:
        """Change the packet's own stamps."""
        stamp = packet.dts if packet.dts is not None else packet.pts
        if stamp is None or packet.time_base is None:
            return
        time = stamp * packet.time_base - self.shift
        expected = self._expected.get(packet.stream_index)
        if expected is not None and (time < expected - RESTART or (self._leaps and time > expected + LEAP)):
            self._bridge(time - expected)
            time = expected
        duration = (packet.duration or 0) * packet.time_base
        self._expected[packet.stream_index] = time + duration
        if self.shift:
            offset = round(self.shift / packet.time_base)
            packet.pts = None if packet.pts is None else packet.pts - offset
            packet.dts = None if packet.dts is None else packet.dts - offset

    def _bridge(self, jump: Fraction) -> None:
        self.shift += jump
        if self.jumps == 0:
            log.warning("the container's clock jumps by %.1f s: bridged", float(jump))
        self.jumps += 1


class FrameClock(Generic[Shown]):
    """Gives decoded frames strictly growing stamps, in a time base fine enough for repairs.

    Attributes:
        time_base: of the stamps that come out.
        nudged, invented: how many stamps were moved, and made up from the frame rate.
    """

    def __init__(self, time_base: Fraction, rate: Fraction, window: int = 0) -> None:
        """`window`: over how many frames stamps are sorted first; for formats that store no display order."""
        self.time_base = fine_time_base(time_base)
        self.nudged = 0
        self.invented = 0
        self._scale = int(time_base / self.time_base)
        self._step = max(1, round(1 / (rate * self.time_base)))
        self._last: int | None = None
        self._window = window
        self._waiting: deque[Shown] = deque()
        self._stamps: list[int] = []
        self._newest = 0

    def stamp(self, frame: Shown, pts: int | None) -> Iterator[tuple[Shown, int]]:
        """The frames that can be shown now with their stamps; `pts` is in the source's time base."""
        if pts is None:
            self._warn_once(self.invented, "the stream has no timestamps: taken from its frame rate")
            self.invented += 1
            stamp = self._newest + self._step if self._stamps or self._last is not None else 0
        else:
            stamp = pts * self._scale
        self._newest = stamp
        self._waiting.append(frame)
        heapq.heappush(self._stamps, stamp)
        yield from self._release(self._window)

    def flush(self) -> Iterator[tuple[Shown, int]]:
        """The frames that still wait."""
        yield from self._release(0)

    def _release(self, keep: int) -> Iterator[tuple[Shown, int]]:
        while len(self._waiting) > keep:
            stamp = heapq.heappop(self._stamps)
            if self._last is not None and stamp <= self._last:
                self._warn_once(self.nudged, "timestamps that do not grow: moved")
                self.nudged += 1
                stamp = self._last + 1
            self._last = stamp
            yield self._waiting.popleft(), stamp

    @staticmethod
    def _warn_once(already: int, message: str) -> None:
        if not already:
            log.warning(message)


def display_stamp(frame: Any) -> int | None:
    """When the decoder says that its frame is shown; formats without display times give the decoding time."""
    return frame.pts if frame.pts is not None else frame.dts  # type: ignore[no-any-return]
