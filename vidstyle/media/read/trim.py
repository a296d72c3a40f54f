"""Trims a source to the range between two times, which then starts at zero."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from fractions import Fraction

import av

from vidstyle.media.frame import DecodedFrame

START_TOLERANCE_SECONDS = Fraction(2, 1000)
"""Seconds by which the first frame may be later than the start: containers round timestamps."""
READ_ON_SECONDS = Fraction(3)
"""Seconds of packets to read after the last frame, for sound that the container stores late."""


class Trimmer:
    """Drops frames and packets outside `start` and `end` (seconds) and shifts the rest."""

    def __init__(
        self, time_base: Fraction, start: Fraction | None, end: Fraction | None, sounds: Iterable[int]
    ) -> None:
        """`sounds`: the indexes of the streams whose packets are waited for at the end."""
        self._time_base = time_base
        self._start = start or Fraction(0)
        self._end = end
        self._offset = round(self._start / time_base)
        self._waiting_for = set(sounds)
        self._before: DecodedFrame | None = None
        self._begun = start is None
        self._over = False

    def apply(self, items: Iterable[DecodedFrame | av.Packet]) -> Iterator[DecodedFrame | av.Packet]:
        """Yield the remaining items."""
        for item in items:
            if isinstance(item, DecodedFrame):
                yield from self._frame(item)
            elif self._keep_packet(item):
                yield item
            if self._over and not self._waiting_for:
                return
        last = self._before
        if last is not None and not self._begun and last.pts + (last.duration or 0) > self._offset:
            yield replace(last, pts=0)

    def _frame(self, frame: DecodedFrame) -> Iterator[DecodedFrame]:
        time = frame.pts * self._time_base
        if not self._begun and time < self._start:
            self._before = frame
            return
        if self._end is not None and time >= self._end:
            self._over = True
            return
        if not self._begun:
            yield from self._first_frame(frame)
        self._begun = True
        yield replace(frame, pts=frame.pts - self._offset)

    def _first_frame(self, frame: DecodedFrame) -> Iterator[DecodedFrame]:
        """Yield the frame that is shown at `start`, unless the next one starts within the tolerance."""
        wait = frame.pts - self._offset
        if self._before is not None and wait * self._time_base > START_TOLERANCE_SECONDS:
            yield replace(self._before, pts=0, duration=wait)

    def _keep_packet(self, packet: av.Packet) -> bool:
        """Whether the packet is in the range; if so, shift its timestamps."""
        if packet.pts is None or packet.time_base is None:
            return True
        time = packet.pts * packet.time_base
        if self._end is not None and time >= self._end:
            self._waiting_for.discard(packet.stream_index)
            if time >= self._end + READ_ON_SECONDS:
                self._waiting_for.clear()
            return False
        return not self._start or self._shift(packet)

    def _shift(self, packet: av.Packet) -> bool:
        assert packet.pts is not None and packet.time_base is not None
        offset = round(self._start / packet.time_base)
        if packet.pts < offset:
            return packet.stream.type == "subtitle" and self._shorten(packet, offset)
        packet.pts -= offset
        packet.dts = None if packet.dts is None else packet.dts - offset
        return True

    @staticmethod
    def _shorten(packet: av.Packet, offset: int) -> bool:
        """Let a subtitle that is still shown at the start begin there."""
        assert packet.pts is not None
        left = packet.pts + (packet.duration or 0) - offset
        if left <= 0:
            return False
        packet.pts = packet.dts = 0
        packet.duration = left
        return True
