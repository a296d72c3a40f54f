"""A container as source: one video stream is decoded, the other streams are passed on as packets."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from fractions import Fraction
from pathlib import Path

import av
from av.stream import Discard

from vidstyle.errors import log
from vidstyle.media.exif import exif_orientation
from vidstyle.media.frame import DecodedFrame
from vidstyle.media.orientation import orientation_of_stream
from vidstyle.media.rational import to_fraction
from vidstyle.media.read.clock import FrameClock
from vidstyle.media.read.decode_report import DecodeReport
from vidstyle.media.read.decoder import Decoder
from vidstyle.media.read.headers import is_jpeg, is_named_as_picture, jpeg_ends_early
from vidstyle.media.read.missing import GapFinder, HeaderCheck
from vidstyle.media.read.packet_clock import BROADCAST, PacketClock, start_shift
from vidstyle.media.read.source import (
    choose_stream,
    frame_rate,
    header_duration,
    is_attached_picture,
    is_chapter_track,
    is_picture_format,
    may_be_still,
    video_streams,
)

DEFAULT_RATE = Fraction(25)
UNSORTED = frozenset({"avi"})
"""Formats that store no display times, so that those of packed B-frames come out of order."""
SORTING_WINDOW = 2
MAX_SEEKS = 6
MAX_FAILURES = 8
"""After so many failures in a row a container is not read on."""


class FilmSource:
    """Reads a container; see `VideoSource`."""

    def __init__(
        self,
        container: av.container.InputContainer,
        name: str,
        max_pixels: int,
        file: Path | None,
        damage: DecodeReport | None = None,
        broken: Collection[int] = (),
    ) -> None:
        """Prepare to read.

        Args:
            file: what the container was opened on, if that is a file, in which one can go back.
            damage: the report to add to; None: a new one.
            broken: indexes of video streams that cannot be decoded.
        """
        self.container: av.container.InputContainer | None = container
        self.name = name
        self.damage = damage or DecodeReport()
        self.damage.broken_streams = len(broken)
        self.stream = choose_stream(container, name, broken)
        self.has_other_videos = len(video_streams(container, broken)) > 1
        chapters = len(container.chapters())
        self.copied_streams = [
            stream
            for stream in container.streams
            if (stream.type != "video" or is_attached_picture(stream))
            and not is_chapter_track(stream, chapters)
        ]
        self.rate = frame_rate(self.stream)
        formats = set(container.format.name.split(","))
        base = to_fraction(self.stream.time_base or 1 / DEFAULT_RATE)
        window = SORTING_WINDOW if formats & UNSORTED else 0
        clock = FrameClock(base, self.rate or DEFAULT_RATE, window)
        self._decoder = Decoder(self.stream, clock, self.damage, max_pixels)
        self.codec = self._decoder.codec
        self._packet_clock = PacketClock(start_shift(container), bool(formats & BROADCAST))
        self.time_base = clock.time_base
        self.sample_aspect = to_fraction(self.stream.sample_aspect_ratio or 0) or None
        self.duration = header_duration(container, self.stream)
        self.frames = self.stream.frames or (
            round(self.duration * self.rate) if self.duration and self.rate else None
        )
        self.may_be_still = may_be_still(container)
        self.orientation = orientation_of_stream(self.stream)
        self._is_photograph = is_picture_format(container)
        self._formats, self._file = formats, file
        self._is_one_picture = (
            file is not None and is_picture_format(container) and is_named_as_picture(file)
        ) and "apng" not in formats
        self._header = HeaderCheck(container, self.stream, formats, file)
        self._from_start, self._awaits_key = True, False
        self._key_gap: Fraction | None = None
        unread = [each for each in container.streams if each not in (self.stream, *self.copied_streams)]
        for stream in unread:
            stream.discard = Discard.all
        alpha = "alpha_mode" in self.stream.metadata  # lies beside the packets
        self._gaps = GapFinder(formats, reads_all=not unread and not alpha)

    def seek(self, time: Fraction) -> None:
        """Continue from the last key frame that is shown at or before a time in seconds."""
        assert self.container is not None
        was_read, self._header.packets, self._awaits_key = self._header.packets, 0, False
        if was_read:
            self._decoder.reset()
            self._packet_clock.reset()
        if self._file is None or self.stream.start_time is None or self.stream.time_base is None:
            # A pipe, or a raw stream in which no time can be found: read from its start.
            if was_read:
                self._rewind()
            return
        wanted = time + self._packet_clock.shift
        for number in range(MAX_SEEKS):
            earlier = wanted - (2**number - 1)
            if earlier <= self._packet_clock.shift:
                break
            try:
                self.container.seek(int(earlier / self.stream.time_base), stream=self.stream)
                entry = self._next_key_time()
                if entry is not None and entry <= wanted:
                    self.container.seek(int(earlier / self.stream.time_base), stream=self.stream)
                    self._from_start, self._awaits_key = False, True
                    return
            except av.FFmpegError:
                break
        self._rewind()

    def decode_keys(self, gap: Fraction | None) -> None:
        """Give only key frames at least `gap` seconds apart; None: everything again."""
        self._key_gap = gap
        # Some demuxers can then leave the other frames unread.
        self.stream.discard = Discard.default if gap is None else Discard.nonkey

    def items(self) -> Iterator[DecodedFrame | av.Packet]:
        """Frames, and packets of the copied streams, from here to the end."""
        for packet in self._packets() if self._key_gap is None else self._key_packets(self._key_gap):
            if self._key_gap is None:
                self._gaps.look(packet)
            # Broadcast streams count their packets; elsewhere the file has ended within this one.
            self.damage.cut_off |= packet.is_corrupt and not self._formats & BROADCAST
            if self._packet_clock.restamp(packet, self._key_gap):
                self._gaps.forget()
                self._decoder.forget_gaps()
                self.damage.leaps = self._packet_clock.leaps
            self._header.count(packet)
            if packet.stream_index != self.stream.index:
                yield packet
            elif self._awaits_key and not packet.is_keyframe:
                continue  # MPEG-TS is entered between key frames
            elif packet.size:  # without content it is a frame like the one before it; a decoder would end
                if self._is_photograph and self.orientation is None:
                    self.orientation = exif_orientation(memoryview(packet))
                self._awaits_key = False
                yield from self._decoder.decode(packet, after_gap=self._gaps.before_picture())
        yield from self._decoder.decode(None)
        if self._key_gap is not None:
            self.damage.cut_off |= self._header.shows_cut()
        elif self._from_start:
            self._header.compare(self.damage)

    def close(self) -> None:
        """Close the file."""
        if self.container is not None:
            self.container.close()

    def _packets(self) -> Iterator[av.Packet]:
        """Every packet that can be read; what cannot be is stepped over."""
        assert self.container is not None
        failures = 0
        wanted = [self.stream, *self.copied_streams]
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
                # PyAV ends so where a stream appears that the header did not name.
                return
            except av.FFmpegError as error:
                failures += 1
                self._gaps.suspect()
                log.debug("%s: a place that cannot be read: %s", self.name, error)
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
        # A film may begin between key frames; a raw stream has no timestamps, only bytes. By its timestamps
        # MPEG-TS is entered after its first key frame.
        ways = [(start, False, False), (start, True, False), (0, False, True)]
        for offset, any_frame, is_byte in ways[:: -1 if self._formats & BROADCAST else 1]:
            try:
                self.container.seek(offset, any_frame=any_frame, unsupported_byte_offset=is_byte)
                return
            except av.FFmpegError:
                log.debug("%s: cannot be rewound", self.name)
