"""Reads the unfinished film of an interrupted run, whose packets are used again."""

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

READABLE = "mov,mp4,m4a,3gp,3g2,mj2,matroska,webm,avi,mpegts,ogg,flv,asf,nut,yuv4mpegpipe,gif,apng"
"""The demuxers of the formats that are written here and can be read back."""
VideoFormat = tuple[str, int, int]
"""Codec, and width and height in pixels."""
LENGTH_PREFIXED = ("h264", "hevc")
"""Codecs whose units have their lengths before them in files, and start codes as they come from encoders."""


@dataclass(frozen=True)
class PacketTimes:
    """The times of a stored picture, in the units of its stream, and where it ends in the file, in bytes."""

    pts: int
    dts: int | None
    key: bool
    duration: int
    end: int


class ResumeSource:
    """The pictures of an unfinished film.

    Attributes:
        stored: how many there are.
        seconds, kept_seconds: how long they last, and how long the kept ones.
        kept: how many are in complete and verified groups of pictures: those before the last key frame.
        times: of the kept ones, in seconds, in the order in which they are shown.
        tick: the unit of the times, in seconds.
        format: the codec and the width and height in pixels.
    """

    def __init__(self, path: Path, verified_bytes: int) -> None:
        """`verified_bytes`: how much of the file is known to be as it was written."""
        self._path = path
        self.format, self.tick, stamps = _stamps(path)
        self.stored = len(stamps)
        first = min((stamp.pts for stamp in stamps), default=0)
        verified = itertools.takewhile(lambda stamp: stamp.end <= verified_bytes, stamps)
        self.kept = _complete(list(verified))
        self.seconds, self.kept_seconds = (
            float((max((each.pts + each.duration for each in part), default=first) - first) * self.tick)
            for part in (stamps, stamps[: self.kept])
        )
        shown = sorted(stamp.pts for stamp in stamps[: self.kept])
        self.times = [pts * self.tick for pts in shown]
        self._decoding_times = _decoding_times(stamps[: self.kept], shown)

    def packets(self, start_codes: bool) -> Iterator[tuple[Fraction, av.Packet]]:
        """The packets of the kept pictures in decoding order, each beside the next of `times`.

        Args:
            start_codes: whether H.264 and HEVC are wanted as encoders give them.
        """
        if not self.kept:
            return
        with _opened(self._path) as container:
            stream = container.streams.video[0]
            is_prefixed = (
                start_codes
                and stream.codec_context.codec.canonical_name in LENGTH_PREFIXED
                and bytes(stream.codec_context.extradata or b"")[:1] == b"\x01"
            )
            stamps = zip(self.times, self._decoding_times, _whole_packets(container), strict=False)
            for time, dts, packet in stamps:
                made = av.Packet(_with_start_codes(bytes(packet))) if is_prefixed else packet
                made.pts, made.dts, made.time_base = packet.pts, dts, self.tick
                made.is_keyframe = packet.is_keyframe
                yield time, made


def frames_in(path: Path, whole: bool = True) -> int:
    """How many frames can be read back from a file; 0 if it cannot be read at all.

    Where it is not `whole`, frames are counted up to the time to which all have come: the last
    packets may need others that are lost.
    """
    _, _, stamps = _stamps(path)
    times = [(stamp.pts, stamp.pts if stamp.dts is None else stamp.dts) for stamp in stamps]
    complete = max((decoded for _, decoded in times), default=0)
    return len(times) if whole else sum(shown <= complete for shown, _ in times)


def _opened(path: Path) -> av.container.InputContainer:
    return av.open(os.fspath(path), options={"format_whitelist": READABLE})


def _whole_packets(container: av.container.InputContainer) -> Iterator[av.Packet]:
    for packet in container.demux(video=0):
        if packet.size and packet.pts is not None and not packet.is_corrupt:
            yield packet


def _stamps(path: Path) -> tuple[VideoFormat | None, Fraction, list[PacketTimes]]:
    """Format, unit of time in seconds, and all packets of pictures, as far as they can be read."""
    found, tick, stamps = None, Fraction(1), []
    try:
        with _opened(path) as container:
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
    """What a film must have in common with the one that it continues."""
    context = stream.codec_context
    return context.codec.canonical_name, context.width, context.height


def _complete(stamps: list[PacketTimes]) -> int:
    """How many pictures come before the last key frame, and are shown before all that follow."""
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
    """Those that are stored; where a container stores none, those of an encoder with the least delay."""
    stored = [stamp.dts for stamp in stamps if stamp.dts is not None and stamp.dts <= stamp.pts]
    if len(stored) == len(stamps) and all(a < b for a, b in zip(stored, stored[1:], strict=False)):
        return stored
    order = {pts: number for number, pts in enumerate(shown)}
    delay = max((number - order[stamp.pts] for number, stamp in enumerate(stamps)), default=0)
    before = [shown[0] - (shown[delay] - shown[number]) for number in range(delay)]
    return [*before, *shown[: len(shown) - delay]]


def _with_start_codes(content: bytes) -> bytes:
    r"""Units with a start code before each in place of its length in four bytes (ISO/IEC 14496-10, Annex B).

    >>> _with_start_codes(b"\0\0\0\2ab\0\0\0\1c")
    b'\x00\x00\x00\x01ab\x00\x00\x00\x01c'
    """
    units, place = [], 0
    while place + 4 <= len(content):
        end = place + 4 + int.from_bytes(content[place : place + 4], "big")
        units += [b"\0\0\0\1", content[place + 4 : end]]
        place = end
    return b"".join(units)
