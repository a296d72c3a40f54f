"""Interleaves packets for a muxer: in decoding order, with valid timestamps."""

from __future__ import annotations

import errno
import heapq
import itertools
import math
from collections import deque
from collections.abc import Callable
from fractions import Fraction

import av

from vidstyle.errors import log

OUTPUT_ERRORS = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG, errno.EPIPE, errno.EIO, errno.EROFS)
"""System errors of the output, not of a packet."""
MAX_QUEUED_BYTES = 32 * 2**20
"""Maximum size of copied packets that wait for video packets."""
GAP_TOLERANCE_SECONDS = Fraction(1, 50)
"""Time between two packets of sound that is not a gap, since times are rounded."""


class Interleaver:
    """Writes packets to a container in the order of their decoding timestamps.

    The muxer's interleaving buffers packets for up to ten seconds if a stream, such as subtitles, has none;
    they are lost if the program is killed. So copied packets wait here for video packets.

    Attributes:
        shifted: number of copied packets with decreasing timestamps, which were shifted.
        dropped: number of packets that were dropped: duplicate, without a timestamp, or refused.
        refused: number of packets that the muxer refused.
        cut: number of packets that were dropped because they start after the end of the video.
        gaps: total duration of gaps between packets of sound, in seconds.
    """

    def __init__(
        self,
        container: av.container.OutputContainer,
        text_last: bool = False,
        on_refusal: Callable[[int, float], None] | None = None,
        max_gap_ticks: float = math.inf,
    ) -> None:
        """All packets wait until `start`.

        Args:
            text_last: whether subtitles are written after all other packets.
            on_refusal: called with the stream's index and the duration in seconds of a refused packet.
            max_gap_ticks: maximum time between two packets of a stream, in its time base.
        """
        self._container, self._text_last, self._on_refusal = container, text_last, on_refusal
        self._max_gap_ticks = max_gap_ticks
        self._pictures: list[av.Packet] | None = []
        self._in_muxer: deque[tuple[Fraction, int | None, float]] = deque()
        self._texts: list[av.Packet] = []
        self._waiting: list[tuple[Fraction, int, av.Packet]] = []
        self._count = itertools.count()
        self._queued_bytes = 0
        self._last: dict[int, int] = {}
        self._sounds: dict[int, av.Packet] = {}
        self.shifted = self.dropped = self.refused = self.cut = 0
        self.gaps = Fraction(0)

    def start(self) -> None:
        """Write the queued packets; the container's header must be written."""
        pictures, self._pictures = self._pictures or [], None
        for packet in pictures:
            self.push_video(packet)

    def push_video(self, packet: av.Packet) -> None:
        """Write a video packet, after all packets that are due before it."""
        if self._pictures is not None:
            self._pictures.append(packet)
            return
        due = packet.dts if packet.dts is not None else packet.pts
        while due is not None and self._waiting and self._waiting[0][0] <= due * packet.time_base:
            self._write(heapq.heappop(self._waiting)[2])
        self._mux(packet, is_picture=True)

    def push(self, packet: av.Packet) -> None:
        """Queue a packet of another stream."""
        if self._is_too_late(packet):
            seconds = float((packet.duration or 0) * packet.time_base)
            self._drop(packet.stream_index, seconds, "the gap before it is too long")
        elif not self._repair_dts(packet):
            self.dropped += 1
        elif packet.stream.type == "audio":
            self._wait(*self._with_duration(packet))
        elif packet.stream.type == "subtitle" and self._text_last:
            self._texts.append(packet)
        else:
            self._wait(packet)

    def _with_duration(self, packet: av.Packet) -> list[av.Packet]:
        """Return the previous packet of sound, with a duration until this one.

        Durations in milliseconds accumulate errors, and the MP4 muxer uses them between fragments.
        """
        before = self._sounds.get(packet.stream_index)
        self._sounds[packet.stream_index] = packet
        if before is None or before.dts is None or packet.dts is None:
            return []
        lasts = packet.dts - before.dts
        if before.duration and (gap := (lasts - before.duration) * packet.time_base) > GAP_TOLERANCE_SECONDS:
            self.gaps += gap
        before.duration = lasts
        return [before]

    def _wait(self, *packets: av.Packet) -> None:
        for packet in packets:
            assert packet.dts is not None
            heapq.heappush(self._waiting, (packet.dts * packet.time_base, next(self._count), packet))
            self._queued_bytes += packet.size
        while self._pictures is None and self._queued_bytes > MAX_QUEUED_BYTES:
            self._write(heapq.heappop(self._waiting)[2])

    def finish(self, end: Fraction | None) -> None:
        """Write all queued packets; drop packets that start after `end`, in seconds."""
        self._wait(*self._sounds.values())
        self._sounds.clear()
        while self._waiting:
            self._write_before(heapq.heappop(self._waiting)[2], end)
        for packet in self._texts:
            self._queued_bytes += packet.size
            self._write_before(packet, end)
        self._texts.clear()

    def _write_before(self, packet: av.Packet, end: Fraction | None) -> None:
        begin = packet.pts if packet.pts is not None else packet.dts
        assert begin is not None
        if end is not None and begin * packet.time_base >= end:
            self.cut += 1
        else:
            self._write(packet)

    def _write(self, packet: av.Packet) -> None:
        self._queued_bytes -= packet.size
        self._mux(packet)

    def _mux(self, packet: av.Packet, is_picture: bool = False) -> None:
        """Pass a packet to the muxer, which may buffer it until a packet with a later time.

        So a refused packet may be an earlier one: the oldest buffered packet that is not video. It is dropped
        without failing. `FilmWriter.finish` checks that all video packets were written.
        """
        stamp = packet.dts if packet.dts is not None else packet.pts
        time = (stamp or 0) * packet.time_base
        seconds = float((packet.duration or 0) * packet.time_base)
        self._in_muxer.append((time, None if is_picture else packet.stream_index, seconds))
        try:
            self._container.mux(packet)
            while self._in_muxer[0][0] < time:
                self._in_muxer.popleft()
        except av.FFmpegError as error:
            refused = next((each for each in self._in_muxer if each[1] is not None), None)
            if refused is None or error.errno in OUTPUT_ERRORS:
                raise
            self._in_muxer.remove(refused)
            _, stream, seconds = refused
            self.refused += 1
            self._drop(stream, seconds, error)

    def _drop(self, stream: int | None, seconds: float, reason: object) -> None:
        self.dropped += 1
        if self._on_refusal is not None and stream is not None:
            self._on_refusal(stream, seconds)
        log.debug("a packet of stream %s was refused: %s", stream, reason)

    def _is_too_late(self, packet: av.Packet) -> bool:
        """Whether the gap before the packet is too long for the container; its muxer could abort."""
        last, base = self._last.get(packet.stream_index), Fraction(packet.stream.time_base or 0)
        if last is None or packet.dts is None or not base:  # unknown before the header is written
            return False
        return (packet.dts - last) * packet.time_base / base > self._max_gap_ticks

    def _repair_dts(self, packet: av.Packet) -> bool:
        """Set the decoding time after the previous packet of the stream; False if that shifts it far."""
        if packet.dts is None:
            packet.dts = packet.pts
        if packet.dts is None:
            return False
        last = self._last.get(packet.stream_index)
        # Two subtitles may start at the same time; two packets of sound may not.
        earliest = packet.dts if last is None else last + (packet.stream.type in ("audio", "video"))
        if packet.dts < earliest:
            if earliest - packet.dts > max(packet.duration or 0, 1):
                return False
            self.shifted += 1
            packet.dts = earliest
        if packet.pts is not None:
            packet.pts = max(packet.pts, packet.dts)
        self._last[packet.stream_index] = packet.dts
        return True
