"""Reads text subtitles."""

from __future__ import annotations

import os
import re
from contextlib import closing
from dataclasses import dataclass
from io import BytesIO

import av
from av.stream import Disposition
from av.subtitles.stream import SubtitleStream
from av.subtitles.subtitle import AssSubtitle

from vidstyle.errors import log
from vidstyle.media.options import ReadOptions
from vidstyle.media.read.open import open_media
from vidstyle.media.write.stream_copy import codec_name
from vidstyle.media.write.transcode import TEXT_CODECS

_SPEAKER_INDEX, _TEXT_INDEX = 3, 8
"""Indexes of two fields of an event, as all decoders of text subtitles return it: order, layer, style, name,
three margins, effect, text."""

_VOICE_PATTERN = re.compile(r"<v(?:\.[^ <>]*+)?\s++([^<>]+)>")
"""Voice span of a cue (WebVTT, section 3.4)."""


@dataclass(frozen=True)
class SubtitleEvent:
    """A subtitle event.

    Attributes:
        start, end: times in seconds, on the clock of the video.
        text: text with ASS markup.
        speaker: the speaker's name if the subtitles state it, else empty.
    """

    start: float
    end: float
    text: str
    speaker: str = ""


def read_subtitles(source: str | os.PathLike[str], options: ReadOptions | None = None) -> list[SubtitleEvent]:
    """Return the events of a file's default text track, else of its first one.

    Returns:
        In the order of the file; empty without a text track. A notice reports tracks of other kinds.

    Raises:
        InputError: the file cannot be read.
    """
    options = options or ReadOptions()
    with closing(open_media(source, allow_url=options.allow_url, max_pixels=options.max_pixels)) as container:
        track = _choose_track(container, str(source))
        return [] if track is None else _read_events(container, track)


def parse_subtitles(text: str) -> list[SubtitleEvent]:
    r"""Return the events in the text of a SubRip or WebVTT file; none if FFmpeg finds none.

    The markup of the format stays in the texts, because FFmpeg's decoder drops the voices of WebVTT.

    >>> parse_subtitles("1\n00:00:01,000 --> 00:00:02,500\n<v Ann>Hello\nthere.")
    [SubtitleEvent(start=1.0, end=2.5, text='<v Ann>Hello\nthere.', speaker='Ann')]
    """
    text = text.lstrip("\ufeff")
    demuxer = "webvtt" if text.startswith("WEBVTT") else "srt"
    try:
        with av.open(BytesIO(text.encode()), "r", demuxer) as container:
            packets = [packet for packet in container.demux() if packet.size and packet.pts is not None]
            return [_event_of_text(packet) for packet in packets]
    except av.FFmpegError:
        return []


def _event_of_text(packet: av.Packet) -> SubtitleEvent:
    text = bytes(packet).decode("utf-8", "replace")
    voice = _VOICE_PATTERN.search(text)
    start, end = _packet_times(packet)
    return SubtitleEvent(start, max(start, end), text, voice[1].strip() if voice else "")


def _packet_times(packet: av.Packet) -> tuple[float, float]:
    """Return start and end in seconds."""
    assert packet.pts is not None and packet.time_base is not None
    start = float(packet.pts * packet.time_base)
    return start, start + float((packet.duration or 0) * packet.time_base)


def _choose_track(container: av.container.InputContainer, name: str) -> SubtitleStream | None:
    tracks = list(container.streams.subtitles)
    readable = [track for track in tracks if codec_name(track) in TEXT_CODECS]
    if tracks and not readable:
        log.warning("%s: its subtitles are bitmaps, which are ignored; use a file with text subtitles", name)
    usual = [track for track in readable if track.disposition & Disposition.default]
    return next(iter([*usual, *readable]), None)


def _read_events(container: av.container.InputContainer, track: SubtitleStream) -> list[SubtitleEvent]:
    found: list[SubtitleEvent] = []
    try:
        for packet in container.demux(track):
            if packet.size and packet.pts is not None:
                found += _decode_events(packet, track)
    except av.FFmpegError as error:
        log.warning("the remaining subtitles cannot be read (%s)", error.strerror)
    return found


def _decode_events(packet: av.Packet, track: SubtitleStream) -> list[SubtitleEvent]:
    start, end = _packet_times(packet)
    try:
        decoded = track.codec_context.decode2(packet) or ()
    except (av.FFmpegError, ValueError):
        return []
    fields = [
        line.ass.decode("utf-8", "replace").split(",", _TEXT_INDEX)
        for line in decoded
        if isinstance(line, AssSubtitle)
    ]
    return [
        SubtitleEvent(start, end, each[_TEXT_INDEX], each[_SPEAKER_INDEX].strip())
        for each in fields
        if len(each) > _TEXT_INDEX
    ]
