"""Subtitles of text, brought from one codec to another: SubRip, ASS, WebVTT, MP4 timed text."""

from __future__ import annotations

import av
from av.subtitles.stream import SubtitleStream
from av.subtitles.subtitle import AssSubtitle, SubtitleSet

TEXT_CODECS = ("subrip", "ass", "ssa", "mov_text", "webvtt", "text", "srt")
"""Canonical names of codecs that hold text rather than pictures."""


class TextConverter:
    """Decodes the packets of one subtitle stream and encodes them into another, at the same times.

    Attributes:
        stream: the new one.
        lost: how many packets could not be read.
    """

    def __init__(
        self, container: av.container.OutputContainer, template: SubtitleStream, encoder: str
    ) -> None:
        self.lost = 0
        self._decoder = template.codec_context
        self._decoder.open(strict=False)
        self.stream: SubtitleStream = container.add_stream(encoder)  # type: ignore[call-overload, assignment]
        self.stream.codec_context.subtitle_header = self._decoder.subtitle_header
        self.stream.time_base = template.time_base

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """The packet in the new codec; none if it holds no words."""
        try:
            made = self._converted(packet)
        except (av.FFmpegError, ValueError):
            self.lost += 1
            return []
        return [] if made is None else [made]

    def flush(self) -> list[av.Packet]:
        """Nothing is held back."""
        return []

    def _converted(self, packet: av.Packet) -> av.Packet | None:
        found = self._decoder.decode2(packet)
        lines = [line for line in found or () if isinstance(line, AssSubtitle) and line.ass]
        if not lines:
            return None
        text = lines[0].ass + b"".join(b"\\N" + line.dialogue for line in lines[1:])
        made = self.stream.codec_context.encode_subtitle(SubtitleSet.create(text, 0, packet.duration or 0))
        made.pts = made.dts = packet.pts
        made.duration, made.time_base = packet.duration, packet.time_base
        made.stream, made.is_keyframe = self.stream, True
        return made
