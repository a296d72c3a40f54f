"""The clock of a container: where it jumps, all streams go on without a jump, and stay together."""

from __future__ import annotations

from collections import deque
from fractions import Fraction

import av

from vidstyle.errors import log

MAX_BACKWARD = Fraction(1)
"""A stamp this many seconds before its predecessor is a new beginning, not a disorder."""
MAX_FORWARD = Fraction(10)
"""In broadcast streams a leap forward by this many seconds is one, too (as in FFmpeg's own program)."""
MAX_GAP = Fraction(3600)
"""Elsewhere a gap of this many seconds in all streams is a damaged stamp; shorter ones may be meant."""
MAX_SOUND_GAP = Fraction(600)
"""The same for sound that is ahead of all other streams; a silent film has no such gap."""
MAX_SHIFTS = 8
"""Maximum number of earlier shifts that a stream may return to."""
BROADCAST = frozenset({"mpegts", "mpeg", "rtsp", "rtp"})
"""Formats whose clock starts anywhere and may jump."""
NEAR_ZERO = Fraction(1)
"""A film that starts within this many seconds of zero keeps its start."""


def start_shift(container: av.container.InputContainer) -> Fraction:
    """The seconds to take off every stamp, so that a broadcast recording begins at zero."""
    start = Fraction(container.start_time or 0, av.time_base)
    names = set(container.format.name.split(","))
    return start if names & BROADCAST or abs(start) >= NEAR_ZERO else Fraction(0)


class PacketClock:
    """Shifts the timestamps of packets, and bridges jumps of the container's clock.

    A stream that jumps takes a shift that another stream has taken already, if it fits. So sound and pictures
    stay together although their packets jump one after the other, and a clock may jump back.

    Attributes:
        shift: seconds that are taken off every stamp before the clock jumps.
        jumps: how often a new shift was needed.
        leaps: those of them that were forward where the format does not allow it: damage.
    """

    def __init__(self, shift: Fraction, broadcast: bool) -> None:
        self.shift = shift
        self._broadcast = broadcast
        self.jumps = self.leaps = 0
        self.reset()

    def reset(self) -> None:
        """Forget the packets seen, before a seek."""
        self._known = deque([self.shift], MAX_SHIFTS)
        self._shifts: dict[int, Fraction] = {}
        self._expected: dict[int, Fraction] = {}
        self._delays: dict[int, Fraction] = {}

    def restamp(self, packet: av.Packet, skipped: Fraction | None = None) -> bool:
        """Change the packet's own stamps; whether the clock has jumped there.

        Args:
            skipped: seconds of packets that may have been left out before this one.
        """
        stamp = packet.dts if packet.dts is not None else packet.pts
        base = packet.time_base
        if stamp is None or base is None:
            return False
        index, gap = packet.stream_index, self._max_gap(packet) + (skipped or 0)
        before = self._shifts.setdefault(index, self.shift)
        shift = self._shifts[index] = self._fitting(index, stamp * base, before, gap)
        time = stamp * base - shift
        if packet.pts is not None and packet.dts is not None:
            packet.pts -= round(self._shift_of_pts(index, packet.pts * base, time, shift, gap) / base)
            packet.dts -= round(shift / base)
        elif packet.pts is not None:
            packet.pts -= round(shift / base)
        elif packet.dts is not None:
            packet.dts -= round(shift / base)
        duration = (packet.duration or 0) * base
        self._expected[index] = time + min(duration, gap)
        if duration > MAX_GAP:  # damaged; muxers refuse it
            packet.duration = 0
        return shift != before

    def _max_gap(self, packet: av.Packet) -> Fraction:
        if self._broadcast:
            return MAX_FORWARD
        return MAX_SOUND_GAP if packet.stream is not None and packet.stream.type == "audio" else MAX_GAP

    def _fitting(self, index: int, stamp: Fraction, shift: Fraction, gap: Fraction) -> Fraction:
        """The shift for the next decoding time of a stream: the stream's own, another's, or a new one."""
        latest = max(self._expected.values(), default=None)
        lowest = self._expected.get(index, Fraction(0)) - MAX_BACKWARD
        time = stamp - shift
        is_late = latest is not None and time > latest + gap
        if lowest <= time and not is_late:
            return shift
        return self._bridged(stamp, self._expected.get(index, latest or Fraction(0)), is_late)

    def _shift_of_pts(
        self, index: int, stamp: Fraction, decoded: Fraction, shift: Fraction, gap: Fraction
    ) -> Fraction:
        """The shift for a time of display. It jumps first where demuxers derive decoding times from it."""
        delay = stamp - shift - decoded
        if abs(delay) > gap:
            shift = self._bridged(stamp, decoded + self._delays.get(index, 0), delay > 0)
            delay = stamp - shift - decoded
        self._delays[index] = delay
        return shift

    def _bridged(self, stamp: Fraction, expected: Fraction, is_forward: bool) -> Fraction:
        """The latest known shift that brings a stamp near the expected time, or a new one."""
        for shift in reversed(self._known):
            if -MAX_BACKWARD <= stamp - shift - expected <= MAX_FORWARD:
                return shift
        shift = stamp - expected
        if self.jumps == 0:
            log.warning("the container's clock jumps by %.1f s: bridged", float(shift - self._known[-1]))
        self.jumps += 1
        self.leaps += is_forward and not self._broadcast
        self._known.append(shift)
        return shift
