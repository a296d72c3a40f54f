"""A container as source: one video stream is decoded, the other streams are passed through as packets."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from fractions import Fraction
from pathlib import Path

import av
from av.stream import Discard
from av.video.stream import VideoStream

from vidstyle.errors import log
from vidstyle.media.exif import exif_orientation
from vidstyle.media.frame import DecodedFrame
from vidstyle.media.orientation import orientation_of_stream
from vidstyle.media.rational import to_fraction
from vidstyle.media.read.clock import FrameClock
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.media.read.decoder import Decoder
from vidstyle.media.read.file_structure.headers import is_jpeg, is_named_as_picture, jpeg_ends_early
from vidstyle.media.read.file_structure.transport_stream import RecordingPart
from vidstyle.media.read.gap_detection import GapFinder, HeaderCheck
from vidstyle.media.read.packet_clock import BROADCAST_FORMATS, PacketClock, start_shift
from vidstyle.media.read.source import (
    MIN_PLAUSIBLE_RATE,
    frame_rate,
    header_duration,
    is_picture_format,
    may_be_still,
)
from vidstyle.media.read.stream_selection import select_streams

DEFAULT_FRAME_RATE = Fraction(25)
UNSORTED_FORMATS = frozenset({"avi"})
"""Formats without presentation times, so that the times of packed B-frames are out of order."""
SORTING_WINDOW_FRAMES = 2
MAX_SEEK_ATTEMPTS = 6
MAX_FAILURES = 8
"""Number of consecutive read errors after which reading ends."""


class FilmSource:
    """Reads a container; see `VideoSource`.

    Attributes:
        skips_pictures: whether to yield only the packets of the copied streams from now on.
    """

    def __init__(
        self,
        container: av.container.InputContainer,
        name: str,
        max_pixels: int,
        file: Path | None,
        damage: DecodeReport | None = None,
        broken: Collection[int] = (),
        is_part: bool = False,
        recording: RecordingPart | None = None,
    ) -> None:
        """Prepare to read.

        Args:
            file: the file of the container, if it is a seekable file.
            damage: the report to add to; None: a new one.
            broken: indexes of video streams that cannot be decoded.
            is_part: whether the container is a part of a recording, whose other video streams are lost video.
            recording: the streams that the tables of a transport stream list, which may still grow.
        """
        self.container: av.container.InputContainer | None = container
        self.name = name
        self.damage = damage or DecodeReport()
        self.damage.broken_streams = len(broken)
        self._recording = recording or RecordingPart()
        self._known = {stream.id for stream in container.streams}
        self._formats, self._file = set(container.format.name.split(",")), file
        self._streams = select_streams(container, name, broken, self._recording.successors, is_part)
        self.stream, self.copied_streams = self._streams.video, self._streams.copied
        self.has_other_videos = self._streams.has_other_videos
        self.rate = frame_rate(self.stream)
        clock, self._has_times = _make_clock(self.stream, self.rate, self._formats)
        self.time_base = clock.time_base
        self._decoder = Decoder(self.stream, clock, self.damage, max_pixels, not self.has_other_videos)
        self.codec = self._decoder.codec
        self._packet_clock = PacketClock(start_shift(container), bool(self._formats & BROADCAST_FORMATS))
        self.sample_aspect = to_fraction(self.stream.sample_aspect_ratio or 0) or None
        self.duration = header_duration(container, self.stream)
        self.frames = self.stream.frames or (
            round(self.duration * self.rate) if self.duration and self.rate else None
        )
        self.may_be_still = may_be_still(container)
        self.orientation = orientation_of_stream(self.stream)
        self._is_photograph = is_picture_format(container)
        self._is_one_picture = (
            self._is_photograph and file is not None and is_named_as_picture(file)
        ) and "apng" not in self._formats
        self._header = HeaderCheck(container, self.stream, self._formats, file)
        self._from_start, self._awaits_key = True, False
        self._key_gap: Fraction | None = None
        self.skips_pictures = False
        has_unread = self._streams.discard_others(container)
        has_alpha = "alpha_mode" in self.stream.metadata  # stored next to the packets
        self._gaps = GapFinder(self._formats, reads_all=not has_unread and not has_alpha)

    def seek(self, time: Fraction) -> None:
        """Continue at the last key frame that is shown at or before a time in seconds."""
        assert self.container is not None
        was_read, self._header.packets, self._awaits_key = self._header.packets, 0, False
        if was_read:
            self._decoder.reset()
            self._packet_clock.reset()
        if self._file is None or self.stream.start_time is None or self.stream.time_base is None:
            # A pipe, or a raw stream without timestamps: read from the start.
            if was_read:
                self._rewind()
            return
        wanted = time + self._packet_clock.shift
        for number in range(MAX_SEEK_ATTEMPTS):
            earlier = wanted - (2**number - 1)
            if earlier <= self._packet_clock.shift:
                break
            try:
                self.container.seek(int(earlier / self.stream.time_base), stream=self.stream)
                entry = self._next_key_time()
                if entry is not None and entry <= wanted:
                    self.container.seek(int(earlier / self.stream.time_base), stream=self.stream)
                    self._from_start, self._awaits_key = False, True
                    self._packet_clock.reset(from_start=False)
                    return
            except av.FFmpegError:
                break
        self._rewind()

    def decode_keys(self, gap: Fraction | None) -> None:
        """Yield only key frames at least `gap` seconds apart; None: all frames again."""
        self._key_gap = gap
        # Some demuxers can then skip the other frames without reading them.
        self.stream.discard = Discard.default if gap is None else Discard.nonkey

    def items(self) -> Iterator[DecodedFrame | av.Packet]:
        """Yield frames, and packets of the copied streams, from here to the end."""
        for packet in self._packets() if self._key_gap is None else self._key_packets(self._key_gap):
            self._inspect(packet)
            if packet.stream in self._streams.lost:
                self.damage.unmatched_packets += packet.size > 0
            elif packet.stream_index != self.stream.index:
                yield packet
            elif self._awaits_key and not packet.is_keyframe:
                continue  # a seek in MPEG-TS may end between key frames
            # An empty packet repeats the previous frame; it would flush the decoder.
            elif packet.size and not self.skips_pictures:
                if self._is_photograph and self.orientation is None:
                    self.orientation = exif_orientation(memoryview(packet))
                self._awaits_key = False
                yield from self._decoder.decode(packet, after_gap=self._gaps.before_picture())
        if not self.skips_pictures:
            yield from self._decoder.decode(None)
        self._inspect_end()

    def _inspect(self, packet: av.Packet) -> None:
        """Correct the stream and the times of a packet, and note damage before it."""
        if self._key_gap is None:
            self._gaps.inspect(packet)
        # Broadcast streams number their packets; in other formats the file ends within this packet.
        self.damage.cut_off |= packet.is_corrupt and not self._formats & BROADCAST_FORMATS
        if packet.stream_index in self._streams.continued:
            packet.stream = self._streams.continued[packet.stream_index]
        if packet.stream_index == self.stream.index and not self._has_times:
            packet.pts = packet.dts = None
        if self._packet_clock.restamp(packet, self._key_gap):
            self._gaps.forget()
            self._decoder.forget_gaps()
        self.damage.clock_jumps = self._packet_clock.forward_jumps
        self._header.count(packet)

    def _inspect_end(self) -> None:
        """Note what the whole film lacks."""
        self.damage.late_streams += len(self._recording.pids - self._known)
        if self._key_gap is not None:
            self.damage.cut_off |= self._header.shows_cut()
        elif self._from_start:
            self._header.compare(self.damage)

    def close(self) -> None:
        """Close the file."""
        if self.container is not None:
            self.container.close()

    def _packets(self) -> Iterator[av.Packet]:
        """Yield every packet that can be read; skip damaged data."""
        assert self.container is not None
        failures = 0
        wanted = [self.stream, *self.copied_streams, *self._streams.list_hidden(self.container)]
        while failures < MAX_FAILURES:
            try:
                for packet in self.container.demux(wanted):
                    failures = 0
                    if packet.size or packet.pts is not None or packet.dts is not None:
                        yield packet
                        if self._is_one_picture:
                            self.damage.cut_off = is_jpeg(bytes(packet)) and jpeg_ends_early(bytes(packet))
                            return
                return
            except IndexError:
                # PyAV raises this if a stream appears that is not in the header.
                return
            except av.FFmpegError as error:
                failures += 1
                self._gaps.suspect()
                log.debug("%s: read error: %s", self.name, error)
                if isinstance(error, TimeoutError | ConnectionError | av.ExitError):
                    log.warning("the connection was lost: %s", error.strerror)
                    return
        self.damage.cut_off = True

    def _key_packets(self, gap: Fraction) -> Iterator[av.Packet]:
        last: Fraction | None = None
        for packet in self._packets():
            if packet.stream_index != self.stream.index or not packet.is_keyframe:
                continue
            stamp = packet.pts if packet.pts is not None else packet.dts
            time = None if stamp is None or packet.time_base is None else stamp * packet.time_base
            if last is None or time is None or not 0 <= time - last < gap:
                last = time
                yield packet

    def _next_key_time(self) -> Fraction | None:
        assert self.container is not None
        for packet in self.container.demux(self.stream):
            if packet.is_keyframe and packet.pts is not None and packet.time_base is not None:
                return packet.pts * packet.time_base
        return None

    def _rewind(self) -> None:
        assert self.container is not None
        start = self.container.start_time or 0
        # A film may start between key frames; a raw stream has no timestamps, only bytes. Seeking in
        # MPEG-TS by time ends after the first key frame.
        ways = [(start, False, False), (start, True, False), (0, False, True)]
        for offset, any_frame, is_byte in ways[:: -1 if self._formats & BROADCAST_FORMATS else 1]:
            try:
                self.container.seek(offset, any_frame=any_frame, unsupported_byte_offset=is_byte)
                return
            except av.FFmpegError:
                log.debug("%s: cannot be rewound", self.name)


def _make_clock(
    stream: VideoStream, rate: Fraction | None, formats: Collection[str]
) -> tuple[FrameClock, bool]:
    """Return the clock of a stream, and whether its times can be used: some demuxers only count frames."""
    base = to_fraction(stream.time_base or 1 / DEFAULT_FRAME_RATE)
    has_times = base <= 1 / MIN_PLAUSIBLE_RATE
    window = 0 if UNSORTED_FORMATS.isdisjoint(formats) else SORTING_WINDOW_FRAMES
    clock = FrameClock(base if has_times else 1 / DEFAULT_FRAME_RATE, rate or DEFAULT_FRAME_RATE, window)
    return clock, has_times
