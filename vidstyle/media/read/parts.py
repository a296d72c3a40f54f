"""A recording in several parts as one source: the streams of each part continue the streams of the first."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import av
from av.stream import Stream

from vidstyle.errors import InputError, log
from vidstyle.media.frame import DecodedFrame
from vidstyle.media.options import ReadOptions
from vidstyle.media.read.decode_report import DecodeReport, describe_count
from vidstyle.media.read.file_structure.transport_stream import FilePart, RecordingPart, RecordingStream
from vidstyle.media.read.film_source import DEFAULT_FRAME_RATE, FilmSource
from vidstyle.media.read.open import open_media
from vidstyle.media.read.source import stream_content


class MultipartSource:
    """Reads parts one after another; see `VideoSource`. A part starts at the end of the frames before it."""

    def __init__(self, parts: Sequence[FilmSource], later: Iterable[FilmSource] = ()) -> None:
        """Take the parts, which share a `DecodeReport`.

        Args:
            parts: the known parts; at least one.
            later: parts that are found when the part before them has been read.
        """
        first = parts[0]
        self.parts, self.name, self.codec = list(parts), first.name, first.codec
        self._later = iter(later)
        self.stream, self.container, self.damage = first.stream, first.container, first.damage
        self.time_base, self.rate, self.sample_aspect = first.time_base, first.rate, first.sample_aspect
        self.orientation, self.may_be_still = first.orientation, False
        self.copied_streams = first.copied_streams
        self.duration = sum((part.duration or Fraction(0) for part in parts), Fraction(0)) or None
        self.frames = sum(part.frames or 0 for part in parts) or None
        self._starts, self._begin, self._only_keys = [Fraction(0)], 0, False
        if len(parts) > 1:
            count = describe_count(len(parts) - 1)
            log.info("%s: its streams start again %s (continued)", self.name, count)

    def seek(self, time: Fraction) -> None:
        """Continue at a key frame at or before a time in seconds, in the last part known to start there."""
        self._begin = sum(start <= time for start in self._starts[1:])
        for number, part in enumerate(self.parts[self._begin :], self._begin):
            part.seek(time - self._starts[number] if number == self._begin else Fraction(0))

    def decode_keys(self, gap: Fraction | None) -> None:
        """See `FilmSource`."""
        self._only_keys = gap is not None
        for part in self.parts:
            part.decode_keys(gap)

    def items(self) -> Iterator[DecodedFrame | av.Packet]:
        """Yield frames, and packets of the copied streams, from here to the end."""
        for number, part in enumerate(self._remaining(), self._begin):
            start = end = self._starts[number]
            streams = _match_streams(part.copied_streams, self.copied_streams)
            for item in part.items():
                if isinstance(item, DecodedFrame):
                    item = replace(item, pts=item.pts + round(start / self.time_base))
                    end = item.pts * self.time_base + 1 / (self.rate or DEFAULT_FRAME_RATE)
                    yield item
                elif item.stream_index in streams:
                    yield _move_packet(item, streams[item.stream_index], start)
                elif self.copied_streams:
                    self.damage.unmatched_packets += 1
            if not self._only_keys:
                self._starts[number + 1 :] = [end]
            elif len(self._starts) == number + 1:  # the end is unknown before all frames were read
                self._starts.append(start + (part.duration or 0))

    def _remaining(self) -> Iterator[FilmSource]:
        """The parts from the current one on."""
        yield from self.parts[self._begin :]
        for part in self._later:
            log.info("%s: its streams start again (continued)", self.name)
            self.parts.append(part)
            yield part

    def close(self) -> None:
        """Close the files."""
        for part in self.parts:
            part.close()


def _move_packet(packet: av.Packet, stream: Stream, seconds: Fraction) -> av.Packet:
    """Shift a packet in time and assign it to a stream of the first part."""
    assert packet.time_base is not None
    offset = round(seconds / packet.time_base)
    packet.pts = None if packet.pts is None else packet.pts + offset
    packet.dts = None if packet.dts is None else packet.dts + offset
    packet.stream = stream
    return packet


def _match_streams(streams: Sequence[Stream], first: Sequence[Stream]) -> dict[int, Stream]:
    """Return the stream of the first part that each stream of a part continues, in order, by its index."""
    left, found = list(first), {}
    for stream in streams:
        match = next((each for each in left if stream_content(each) == stream_content(stream)), None)
        if match is not None:
            left.remove(match)
            found[stream.index] = match
    return found


def open_recording(file: Path, found: Sequence[RecordingPart], options: ReadOptions) -> MultipartSource:
    """The parts of a recording in a file; those without pictures are passed over.

    Raises:
        InputError: no part has pictures.
    """
    damage, parts = DecodeReport(), []
    ends = [*(part.start for part in found[1:]), file.stat().st_size]
    for part, end in zip(found, ends, strict=True):
        try:
            parts.append(_open_part(FilePart(file, part.start, end), part, str(file), options, damage, file))
        except InputError as error:
            log.warning("%s: bytes %d to %d are skipped: %s", file, part.start, end, error.reason)
            damage.cut_off = True
    if not parts:
        raise InputError(file, "not a readable video")
    return MultipartSource(parts)


def open_recording_stream(stream: RecordingStream, name: str, options: ReadOptions) -> MultipartSource:
    """A recording that comes as a stream; later parts without pictures are passed over.

    Raises:
        InputError: the first part has no pictures.
    """
    damage = DecodeReport()
    first = _open_part(stream, stream.part, name, options, damage, is_part=False)
    return MultipartSource([first], _later_parts(stream, name, options, damage))


def _later_parts(
    stream: RecordingStream, name: str, options: ReadOptions, damage: DecodeReport
) -> Iterator[FilmSource]:
    while stream.enter_next_part():
        try:
            yield _open_part(stream, stream.part, name, options, damage)
        except InputError as error:
            log.warning("%s: what begins at byte %d is skipped: %s", name, stream.part.start, error.reason)
            damage.cut_off = True


def _open_part(
    content: FilePart | RecordingStream,
    part: RecordingPart,
    name: str,
    options: ReadOptions,
    damage: DecodeReport,
    file: Path | None = None,
    is_part: bool = True,
) -> FilmSource:
    pixels = options.max_pixels
    container = open_media(content, max_pixels=pixels, hwaccel=options.hwaccel, format="mpegts")
    try:
        return FilmSource(container, name, pixels, file, damage, is_part=is_part, recording=part)
    except BaseException:
        container.close()
        raise
