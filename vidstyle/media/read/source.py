"""The interface of video sources, and facts about the streams of a container."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from fractions import Fraction
from typing import Protocol

import av
from av.audio.stream import AudioStream
from av.stream import Disposition

from vidstyle.errors import InputError, log
from vidstyle.media.frame import DecodedFrame
from vidstyle.media.orientation import Orientation
from vidstyle.media.rational import to_fraction
from vidstyle.media.read.decode_report import DecodeReport


class VideoSource(Protocol):
    """Yields decoded frames in presentation order, interleaved with packets of other streams."""

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
        """Continue at a key frame at or before a time in seconds, if possible."""

    def items(self) -> Iterator[DecodedFrame | av.Packet]:
        """Yield all frames and packets from here to the end."""

    def close(self) -> None:
        """Close the files."""


MAX_PLAUSIBLE_RATE = 480
"""Maximum plausible frame rate: streams with a time base of milliseconds may report a thousand."""
MIN_PLAUSIBLE_RATE = Fraction(1, 3600)
"""Minimum plausible frame rate: by a damaged index, a frame may last half a day."""
STILL_BRANDS = frozenset({"avif", "heic", "heix", "mif1"})
"""MP4 files of these brands hold pictures (MPEG-H part 12)."""


def choose_stream(
    container: av.container.InputContainer, name: str, broken: Collection[int] = ()
) -> av.video.stream.VideoStream:
    """Return the video stream to restyle: the longest decodable one that is not a cover picture.

    Args:
        broken: indexes of streams to ignore.

    Raises:
        InputError: there is no video stream, or this build cannot decode it.
    """
    streams = video_streams(container, broken)
    if not streams:
        raise InputError(name, "no video stream")
    if container.metadata.get("major_brand") in STILL_BRANDS:
        streams = _primary_item(streams, name)
    streams = [stream for stream in streams if stream.codec_context is not None] or streams
    chosen = max(streams, key=lambda stream: (_stream_seconds(stream) or 0, -stream.index))
    if len(streams) > 1:
        log.info("%d video streams; stream %d, the longest, is used", len(streams), chosen.index)
    if chosen.codec_context is None:
        raise InputError(name, "its video codec is not supported by this build")
    return chosen


def video_streams(
    container: av.container.InputContainer, broken: Collection[int] = ()
) -> list[av.video.stream.VideoStream]:
    """Return the video streams that are neither cover pictures nor broken."""
    return [
        stream
        for stream in container.streams.video
        if stream.index not in broken and not is_attached_picture(stream)
    ]


def _primary_item(streams: list[av.video.stream.VideoStream], name: str) -> list[av.video.stream.VideoStream]:
    """Return the streams of the picture itself, without thumbnail, gain map and depth (ISO/IEC 23008-12)."""
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

    The track has no flag: it is data, handled as text, with one packet per chapter.
    """
    handler = stream.metadata.get("handler_name", "").lower()
    return (
        stream.type == "data"
        and stream.frames == chapters > 0
        and ("text" in handler or "subtitle" in handler)
    )


def stream_content(stream: av.stream.Stream) -> tuple[object, ...]:
    """Return the properties that must be equal for packets of one stream to continue another."""
    context = stream.codec_context
    codec = None if context is None else context.name
    sound = (stream.rate, stream.layout.name) if isinstance(stream, AudioStream) else ()
    return stream.type, codec, *sound


def is_picture_format(container: av.container.InputContainer) -> bool:
    """Whether the container format usually holds a single picture."""
    names = container.format.name.split(",")
    return any(name.endswith("_pipe") or name in ("gif", "apng") for name in names)


def may_be_still(container: av.container.InputContainer) -> bool:
    """Whether a single frame in this container is a picture rather than a very short film."""
    return is_picture_format(container) or container.metadata.get("major_brand") in STILL_BRANDS


def frame_rate(stream: av.video.stream.VideoStream) -> Fraction | None:
    """Return the frame rate by the header or the first packets, or None."""
    average, guessed = stream.average_rate, stream.guessed_rate
    rate = to_fraction((average if average and average <= MAX_PLAUSIBLE_RATE else guessed) or 0)
    return rate if rate >= MIN_PLAUSIBLE_RATE else None


def header_duration(
    container: av.container.InputContainer, stream: av.video.stream.VideoStream
) -> Fraction | None:
    """Return the duration of the stream, or else of the container, in seconds."""
    whole = Fraction(container.duration, av.time_base) if container.duration else None
    return _stream_seconds(stream) or whole


def _stream_seconds(stream: av.video.stream.VideoStream) -> Fraction | None:
    """Return the duration of a stream; Matroska's tag first, as FFmpeg may copy the container's duration."""
    tagged = _parse_seconds(stream.metadata.get("DURATION", ""))
    if tagged or not stream.duration or stream.time_base is None:
        return tagged
    return stream.duration * stream.time_base


def _parse_seconds(text: str) -> Fraction | None:
    """Parse Matroska's "00:01:02.345" into seconds."""
    try:
        hours, minutes, seconds = text.split(":")
        return int(hours) * 3600 + int(minutes) * 60 + Fraction(seconds)
    except ValueError:
        return None
