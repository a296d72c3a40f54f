"""The interface of video sources, and facts about the streams of a container."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from fractions import Fraction
from typing import Protocol

import av
from av.stream import Disposition

from vidstyle.errors import InputError, log
from vidstyle.media.frame import DecodedFrame
from vidstyle.media.orientation import Orientation
from vidstyle.media.rational import to_fraction
from vidstyle.media.read.decode_report import DecodeReport


class VideoSource(Protocol):
    """Decoded frames in the order that they are shown in, with packets of other streams among them."""

    name: str
    codec: str
    time_base: Fraction
    rate: Fraction | None
    sample_aspect: Fraction | None
    duration: Fraction | None
    frames: int | None
    may_be_still: bool
    orientation: Orientation | None
    damage: DecodeReport
    container: av.container.InputContainer | None
    copied_streams: list[av.stream.Stream]

    def seek(self, time: Fraction) -> None:
        """Continue from a key frame at or before a time in seconds, where that can be done."""

    def items(self) -> Iterator[DecodedFrame | av.Packet]:
        """Everything from here to the end."""

    def close(self) -> None:
        """Close the files."""


MAX_PLAUSIBLE_RATE = 480
"""Maximum plausible frame rate: streams with a time base of milliseconds may claim a thousand."""
MIN_PLAUSIBLE_RATE = Fraction(1, 3600)
"""Minimum plausible frame rate: a damaged index may give a frame half a day."""
STILL_BRANDS = frozenset({"avif", "heic", "heix", "mif1"})
"""MP4 files of these brands hold pictures (MPEG-H part 12)."""


def choose_stream(
    container: av.container.InputContainer, name: str, broken: Collection[int] = ()
) -> av.video.stream.VideoStream:
    """The video stream to restyle: the longest that this build decodes and that is not a cover picture.

    Args:
        broken: indexes of streams that are not taken.

    Raises:
        InputError: there is none, or this build cannot decode it.
    """
    streams = video_streams(container, broken)
    if not streams:
        raise InputError(name, "no video stream")
    if container.metadata.get("major_brand") in STILL_BRANDS:
        streams = _primary_item(streams, name)
    streams = [stream for stream in streams if stream.codec_context is not None] or streams
    chosen = max(streams, key=lambda stream: (_own_seconds(stream) or 0, -stream.index))
    if len(streams) > 1:
        log.info("%d video streams: stream %d is taken, the longest", len(streams), chosen.index)
    if chosen.codec_context is None:
        raise InputError(name, "its video codec is not one that this build decodes")
    return chosen


def video_streams(
    container: av.container.InputContainer, broken: Collection[int] = ()
) -> list[av.video.stream.VideoStream]:
    """The video streams that are neither cover pictures nor broken."""
    return [
        stream
        for stream in container.streams.video
        if stream.index not in broken and not is_attached_picture(stream)
    ]


def _primary_item(streams: list[av.video.stream.VideoStream], name: str) -> list[av.video.stream.VideoStream]:
    """The picture itself, not its thumbnail, gain map or depth (ISO/IEC 23008-12)."""
    primary = [stream for stream in streams if stream.disposition & Disposition.default]
    tiles = [stream for stream in streams if stream.disposition & Disposition.dependent]
    if tiles and not primary:
        raise InputError(name, f"is a picture in {len(tiles)} tiles", "save it as JPEG or PNG")
    return primary or streams


def is_attached_picture(stream: av.stream.Stream) -> bool:
    """Whether the stream is a cover picture rather than a film."""
    return bool(Disposition(stream.disposition) & Disposition.attached_pic)


def is_chapter_track(stream: av.stream.Stream, chapters: int) -> bool:
    """Whether the stream holds the names of a QuickTime film's chapters, which FFmpeg also gives as chapters.

    The track has no mark of its own: it is data, handled as text, with a packet for each chapter.
    """
    handler = stream.metadata.get("handler_name", "").lower()
    return (
        stream.type == "data"
        and stream.frames == chapters > 0
        and ("text" in handler or "subtitle" in handler)
    )


def is_picture_format(container: av.container.InputContainer) -> bool:
    """Whether the container is of a kind that mostly holds a single picture."""
    names = container.format.name.split(",")
    return any(name.endswith("_pipe") or name in ("gif", "apng") for name in names)


def may_be_still(container: av.container.InputContainer) -> bool:
    """Whether a single frame in this container is a picture rather than a very short film."""
    return is_picture_format(container) or container.metadata.get("major_brand") in STILL_BRANDS


def frame_rate(stream: av.video.stream.VideoStream) -> Fraction | None:
    """Frames per second according to the header or the first packets, or None."""
    average, guessed = stream.average_rate, stream.guessed_rate
    rate = to_fraction((average if average and average <= MAX_PLAUSIBLE_RATE else guessed) or 0)
    return rate if rate >= MIN_PLAUSIBLE_RATE else None


def header_duration(
    container: av.container.InputContainer, stream: av.video.stream.VideoStream
) -> Fraction | None:
    """How long the stream is, or else the whole container."""
    whole = Fraction(container.duration, av.time_base) if container.duration else None
    return _own_seconds(stream) or whole


def _own_seconds(stream: av.video.stream.VideoStream) -> Fraction | None:
    """Matroska's tag comes first: for want of a duration FFmpeg sets the container's."""
    tagged = _seconds(stream.metadata.get("DURATION", ""))
    if tagged or not stream.duration or stream.time_base is None:
        return tagged
    return stream.duration * stream.time_base


def _seconds(text: str) -> Fraction | None:
    """Matroska's "00:01:02.345" in seconds."""
    try:
        hours, minutes, seconds = text.split(":")
        return int(hours) * 3600 + int(minutes) * 60 + Fraction(seconds)
    except ValueError:
        return None
