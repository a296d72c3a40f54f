"""Reads the unfinished film of an interrupted run, whose packets are reused."""

from __future__ import annotations

import itertools
import os
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av

from vidstyle.errors import log
from vidstyle.media.rational import to_fraction

READABLE_FORMATS = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,ogg,flv,asf,nut,yuv4mpegpipe,gif,apng"
"""Demuxers of the output formats that can be read back."""
VideoFormat = tuple[str, int, int]
"""Codec, and width and height in pixels."""
LENGTH_PREFIXED_CODECS = ("h264", "hevc")
"""Codecs whose units have length prefixes in files, and start codes as output of an encoder."""


@dataclass(frozen=True)
class PacketTimes:
    """Times of a stored picture, in the time base of its stream, and the offset of its end in the file."""

    pts: int
    dts: int | None
    key: bool
    duration: int
    end: int


class ResumeSource:
    """The pictures of an unfinished film.

    Attributes:
        stored: number of pictures.
        seconds, kept_seconds: duration of all pictures, and of the kept ones.
        kept: number of pictures in complete and verified groups of pictures: before the last key frame.
        times: times of the kept pictures, in seconds, in presentation order.
        tick: the time base in seconds.
        format: codec, width and height in pixels.
    """

    def __init__(self, path: Path, verified_bytes: int) -> None:
        """`verified_bytes`: number of leading bytes that are verified to be unchanged."""
        self._path = path
        self.format, self.tick, stamps = _read_times(path)
        self.stored = len(stamps)
        first = min((stamp.pts for stamp in stamps), default=0)
        verified = itertools.takewhile(lambda stamp: stamp.end <= verified_bytes, stamps)
        self.kept = _count_complete(list(verified))
        self.seconds, self.kept_seconds = (
            float((max((each.pts + each.duration for each in part), default=first) - first) * self.tick)
            for part in (stamps, stamps[: self.kept])
        )
        shown = sorted(stamp.pts for stamp in stamps[: self.kept])
        self.times = [pts * self.tick for pts in shown]
        self._decoding_times = _decoding_times(stamps[: self.kept], shown)

    def packets(self, start_codes: bool) -> Iterator[tuple[Fraction, av.Packet]]:
        """Yield the packets of the kept pictures in decoding order, each with the next element of `times`.

        Args:
            start_codes: whether H.264 and HEVC need start codes, as from an encoder.
        """
        if not self.kept:
            return
        with _open_film(self._path) as container:
            stream = container.streams.video[0]
            is_prefixed = (
                start_codes
                and stream.codec_context.codec.canonical_name in LENGTH_PREFIXED_CODECS
                and bytes(stream.codec_context.extradata or b"")[:1] == b"\x01"
            )
            stamps = zip(self.times, self._decoding_times, _whole_packets(container), strict=False)
            for time, dts, packet in stamps:
                made = av.Packet(_with_start_codes(bytes(packet))) if is_prefixed else packet
                made.pts, made.dts, made.time_base = packet.pts, dts, self.tick
                made.is_keyframe = packet.is_keyframe
                yield time, made


def count_frames(path: Path, whole: bool = True) -> int:
    """Count the frames that can be read back from a file; 0 if it cannot be read.

    If it is not `whole`, count the frames up to the last time before which no frame is missing: the last
    packets may depend on lost ones.
    """
    _, _, stamps = _read_times(path)
    times = [(stamp.pts, stamp.pts if stamp.dts is None else stamp.dts) for stamp in stamps]
    complete = max((decoded for _, decoded in times), default=0)
    return len(times) if whole else sum(shown <= complete for shown, _ in times)


def _open_film(path: Path) -> av.container.InputContainer:
    return av.open(os.fspath(path), options={"format_whitelist": READABLE_FORMATS})


def _whole_packets(container: av.container.InputContainer) -> Iterator[av.Packet]:
    for packet in container.demux(video=0):
        if packet.size and packet.pts is not None and not packet.is_corrupt:
            yield packet


def _read_times(path: Path) -> tuple[VideoFormat | None, Fraction, list[PacketTimes]]:
    """Return format, time base in seconds, and the times of all readable video packets."""
    found, tick, stamps = None, Fraction(1), []
    try:
        with _open_film(path) as container:
            found = video_format(container.streams.video[0])
            for packet in _whole_packets(container):
                assert packet.pts is not None and packet.time_base is not None
                tick = to_fraction(packet.time_base)
                times = packet.pts, packet.dts, packet.is_keyframe, packet.duration or 0
                stamps.append(PacketTimes(*times, (packet.pos or 0) + packet.size))
    except (av.FFmpegError, OSError, IndexError) as error:
        log.debug("%s: %s", path, error)
    return found, tick, stamps


def video_format(stream: av.VideoStream) -> VideoFormat:
    """Return the properties that a film must share with the one that it continues."""
    context = stream.codec_context
    return context.codec.canonical_name, context.width, context.height


def _count_complete(stamps: list[PacketTimes]) -> int:
    """Count the pictures before the last key frame that are shown before all later ones."""
    earliest, kept = float("inf"), 0
    latest: list[int] = []
    for stamp in stamps:
        latest.append(max(stamp.pts, latest[-1] if latest else stamp.pts))
    for number in range(len(stamps) - 1, 0, -1):
        earliest = min(earliest, stamps[number].pts)
        if stamps[number].key and latest[number - 1] < earliest:
            kept = number
            break
    return kept


def _decoding_times(stamps: list[PacketTimes], shown: list[int]) -> list[int]:
    """Return the stored decoding times; if a container stores none, times with the least encoder delay."""
    stored = [stamp.dts for stamp in stamps if stamp.dts is not None and stamp.dts <= stamp.pts]
    if len(stored) == len(stamps) and all(a < b for a, b in zip(stored, stored[1:], strict=False)):
        return stored
    order = {pts: number for number, pts in enumerate(shown)}
    delay = max((number - order[stamp.pts] for number, stamp in enumerate(stamps)), default=0)
    before = [shown[0] - (shown[delay] - shown[number]) for number in range(delay)]
    return [*before, *shown[: len(shown) - delay]]


def _with_start_codes(content: bytes) -> bytes:
    r"""Replace the four-byte length prefix of each unit with a start code (ISO/IEC 14496-10, Annex B).

    >>> _with_start_codes(b"\0\0\0\2ab\0\0\0\1c")
    b'\x00\x00\x00\x01ab\x00\x00\x00\x01c'
    """
    units, place = [], 0
    while place + 4 <= len(content):
        end = place + 4 + int.from_bytes(content[place : place + 4], "big")
        units += [b"\0\0\0\1", content[place + 4 : end]]
        place = end
    return b"".join(units)
