"""A recording in several parts as one source: the streams of each part continue those of the first."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

import av
from av.audio.stream import AudioStream
from av.stream import Stream

from vidstyle.errors import log
from vidstyle.media.frame import DecodedFrame
from vidstyle.media.read.film_source import DEFAULT_RATE, FilmSource


class PartedSource:
    """Reads parts one after the other; see `VideoSource`. A part begins when the pictures before it end."""

    def __init__(self, parts: Sequence[FilmSource]) -> None:
        """The parts share a report of damage."""
        first = parts[0]
        self.parts, self.name, self.codec = parts, first.name, first.codec
        self.stream, self.container, self.damage = first.stream, first.container, first.damage
        self.time_base, self.rate, self.sample_aspect = first.time_base, first.rate, first.sample_aspect
        self.orientation, self.may_be_still = first.orientation, False
        self.copied_streams = first.copied_streams
        self.duration: Fraction | None = sum((part.duration or Fraction(0) for part in parts), Fraction(0))
        self.frames: int | None = sum(part.frames or 0 for part in parts)
        self._starts, self._begin, self._only_keys = [Fraction(0)], 0, False
        log.info("%s: its streams begin anew %d times: continued", self.name, len(parts) - 1)

    def seek(self, time: Fraction) -> None:
        """Continue from a key frame at or before a time in seconds, in the last part known to begin there."""
        self._begin = sum(start <= time for start in self._starts[1:])
        for number, part in enumerate(self.parts[self._begin :], self._begin):
            part.seek(time - self._starts[number] if number == self._begin else Fraction(0))

    def decode_keys(self, gap: Fraction | None) -> None:
        """See `FilmSource`."""
        self._only_keys = gap is not None
        for part in self.parts:
            part.decode_keys(gap)

    def items(self) -> Iterator[DecodedFrame | av.Packet]:
        """Frames, and packets of the copied streams, from here to the end."""
        for number, part in enumerate(self.parts[self._begin :], self._begin):
            start = end = self._starts[number]
            streams = _continued(part.copied_streams, self.copied_streams)
            for item in part.items():
                if isinstance(item, DecodedFrame):
                    item = replace(item, pts=item.pts + round(start / self.time_base))
                    end = item.pts * self.time_base + 1 / (self.rate or DEFAULT_RATE)
                    yield item
                elif item.stream_index in streams:
                    yield _moved(item, streams[item.stream_index], start)
                elif self.copied_streams:
                    self.damage.unmatched_packets += 1
            if not self._only_keys:
                self._starts[number + 1 :] = [end]
            elif len(self._starts) == number + 1:  # the end is unknown before all frames were read
                self._starts.append(start + (part.duration or 0))

    def close(self) -> None:
        """Close the files."""
        for part in self.parts:
            part.close()


def _moved(packet: av.Packet, stream: Stream, seconds: Fraction) -> av.Packet:
    """The packet as one of a stream of the first part, later."""
    assert packet.time_base is not None
    offset = round(seconds / packet.time_base)
    packet.pts = None if packet.pts is None else packet.pts + offset
    packet.dts = None if packet.dts is None else packet.dts + offset
    packet.stream = stream
    return packet


def _continued(streams: Sequence[Stream], first: Sequence[Stream]) -> dict[int, Stream]:
    """The stream of the first part that each stream of a part continues, in their order, by its index."""
    left, found = list(first), {}
    for stream in streams:
        match = next((each for each in left if _content(each) == _content(stream)), None)
        if match is not None:
            left.remove(match)
            found[stream.index] = match
    return found


def _content(stream: Stream) -> tuple[object, ...]:
    """What must be the same for packets of one stream to continue another."""
    context = stream.codec_context
    codec = None if context is None else context.name
    sound = (stream.rate, stream.layout.name) if isinstance(stream, AudioStream) else ()
    return stream.type, codec, *sound
