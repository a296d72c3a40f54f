"""The clock of a container: jumps are bridged, and all streams stay synchronized."""

from __future__ import annotations

from collections import deque
from fractions import Fraction

import av

from vidstyle.errors import log

MAX_BACKWARD_SECONDS = Fraction(1)
"""A timestamp further than this before its predecessor is a jump, not a wrong order."""
MAX_FORWARD_SECONDS = Fraction(10)
"""In broadcast streams, a larger step forward is a jump, too (as in the ffmpeg program)."""
MAX_GAP_SECONDS = Fraction(3600)
"""In other formats, a longer gap in all streams is a damaged timestamp; shorter gaps may be intended."""
MAX_SOUND_GAP_SECONDS = Fraction(600)
"""Maximum gap of sound that is ahead of all other streams; a silent film has no such gap."""
MAX_SHIFTS = 8
"""Maximum number of earlier shifts to which a stream can return."""
BROADCAST_FORMATS = frozenset({"mpegts", "mpeg", "rtsp", "rtp"})
"""Formats whose clock starts at any time and may jump."""
MAX_KEPT_START_SECONDS = Fraction(1)
"""A film that starts this near to zero keeps its start time."""


def start_shift(container: av.container.InputContainer) -> Fraction:
    """Return the seconds to subtract from every timestamp, so that a broadcast recording starts at zero."""
    start = Fraction(container.start_time or 0, av.time_base)
    names = set(container.format.name.split(","))
    return start if names & BROADCAST_FORMATS or abs(start) >= MAX_KEPT_START_SECONDS else Fraction(0)


class PacketClock:
    """Shifts the timestamps of packets, and bridges jumps of the container's clock.

    A stream that jumps uses the shift of another stream, if it fits. So sound and pictures stay synchronized
    although their packets jump one after the other, and a clock may jump back.

    Attributes:
        shift: seconds that are subtracted from every timestamp before the clock jumps.
        jumps: number of new shifts.
        forward_jumps: number of forward jumps in formats that do not allow them: damage.
    """

    def __init__(self, shift: Fraction, broadcast: bool) -> None:
        self.shift = shift
        self._broadcast = broadcast
        self.jumps = self.forward_jumps = 0
        self.reset()

    def reset(self, from_start: bool = True) -> None:
        """Clear the state before a seek.

        Args:
            from_start: whether the film is read from its start, so that a much later first time is a jump.
        """
        self._start = Fraction(0) if from_start else None
        self._known = deque([self.shift], MAX_SHIFTS)
        self._shifts: dict[int, Fraction] = {}
        self._expected: dict[int, Fraction] = {}
        self._delays: dict[int, Fraction] = {}

    def restamp(self, packet: av.Packet, skipped: Fraction | None = None) -> bool:
        """Change the packet's timestamps in place; return whether the clock has jumped there.

        Args:
            skipped: maximum duration of skipped packets before this one, in seconds.
        """
        stamp = packet.dts if packet.dts is not None else packet.pts
        base = packet.time_base
        if stamp is None or base is None:
            return False
        index, gap = packet.stream_index, self._max_gap(packet) + (skipped or 0)
        before = self._shifts.setdefault(index, self.shift)
        shift = self._shifts[index] = self._choose_shift(index, stamp * base, before, gap)
        time = stamp * base - shift
        if packet.pts is not None and packet.dts is not None:
            packet.pts -= round(self._shift_of_pts(index, packet.pts * base, time, shift, gap) / base)
            packet.dts -= round(shift / base)
        elif packet.pts is not None:
            packet.pts -= round(shift / base)
        elif packet.dts is not None:
            packet.dts -= round(shift / base)
        duration = (packet.duration or 0) * base
        if duration > MAX_GAP_SECONDS:  # damaged; muxers reject it
            packet.duration, duration = 0, Fraction(0)
        self._expected[index] = time + min(duration, gap)
        return shift != before

    def _max_gap(self, packet: av.Packet) -> Fraction:
        if self._broadcast:
            return MAX_FORWARD_SECONDS
        return (
            MAX_SOUND_GAP_SECONDS
            if packet.stream is not None and packet.stream.type == "audio"
            else MAX_GAP_SECONDS
        )

    def _choose_shift(self, index: int, stamp: Fraction, shift: Fraction, gap: Fraction) -> Fraction:
        """Return the shift for the next decoding time: the stream's own, another stream's, or a new one."""
        latest = max(self._expected.values(), default=self._start)
        lowest = self._expected.get(index, Fraction(0)) - MAX_BACKWARD_SECONDS
        time = stamp - shift
        is_late = latest is not None and time > latest + gap
        if lowest <= time and not is_late:
            return shift
        return self._bridge_jump(stamp, self._expected.get(index, latest or Fraction(0)), is_late)

    def _shift_of_pts(
        self, index: int, stamp: Fraction, decoded: Fraction, shift: Fraction, gap: Fraction
    ) -> Fraction:
        """Return the shift for a presentation time; it jumps first if decoding times derive from it."""
        delay = stamp - shift - decoded
        if abs(delay) > gap:
            shift = self._bridge_jump(stamp, decoded + self._delays.get(index, 0), delay > 0)
            delay = stamp - shift - decoded
        self._delays[index] = delay
        return shift

    def _bridge_jump(self, stamp: Fraction, expected: Fraction, is_forward: bool) -> Fraction:
        """Return the latest known shift that brings a timestamp near the expected time, or a new one."""
        for shift in reversed(self._known):
            if -MAX_BACKWARD_SECONDS <= stamp - shift - expected <= MAX_FORWARD_SECONDS:
                return shift
        shift = stamp - expected
        if self.jumps == 0:
            log.warning("the container's clock jumps by %.1f s (bridged)", float(shift - self._known[-1]))
        self.jumps += 1
        self.forward_jumps += is_forward and not self._broadcast
        self._known.append(shift)
        return shift
