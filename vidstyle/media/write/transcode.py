"""Transcodes audio and text subtitles for containers that do not support their codecs."""

from __future__ import annotations

from collections.abc import Container

import av
import numpy as np
from av.audio.stream import AudioStream
from av.stream import Stream
from av.subtitles.codeccontext import SubtitleCodecContext
from av.subtitles.stream import SubtitleStream
from av.subtitles.subtitle import AssSubtitle, SubtitleSet

from vidstyle.media.audio import DEFAULT_FRAME_SIZE, AudioDecoder, AudioEncoder, Loss

TEXT_CODECS = ("subrip", "ass", "ssa", "mov_text", "webvtt", "text", "srt")
"""Canonical names of subtitle codecs with text instead of bitmaps."""


class CopiedStream:
    """A stream of a source that is copied or transcoded into another container.

    Attributes:
        stream: the stream in the new container.
        loss: packets that could not be used.
    """

    stream: Stream

    def __init__(self, stream: Stream) -> None:
        self.stream, self.loss = stream, Loss()

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """Return the packets of the new stream for a packet of the source."""
        raise NotImplementedError

    def make_sample(self, packet: av.Packet) -> list[av.Packet]:
        """Return the packets that the muxer would get for a packet of the source, which is not changed."""
        copy = av.Packet(bytes(packet))
        copy.pts, copy.dts, copy.time_base = packet.pts, packet.dts, packet.time_base
        copy.duration, copy.stream, copy.is_keyframe = packet.duration, packet.stream, True
        return self.packets(copy)

    def flush(self) -> list[av.Packet]:
        """Return the remaining packets."""
        return []


class SubtitleTranscoder(CopiedStream):
    """Decodes the packets of a subtitle stream and encodes them with another codec at the same times."""

    def __init__(
        self, container: av.container.OutputContainer, template: SubtitleStream, encoder: str
    ) -> None:
        self._decoder = template.codec_context
        self._decoder.open(strict=False)
        super().__init__(container.add_stream(encoder))  # type: ignore[call-overload]
        self._encoder: SubtitleCodecContext = self.stream.codec_context  # type: ignore[assignment]
        self._encoder.subtitle_header = self._decoder.subtitle_header
        self.stream.time_base = template.time_base

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """Return the packet in the new codec; none if it has no text."""
        try:
            made = self._convert(packet)
        except (av.FFmpegError, ValueError):
            self.loss.add(packet)
            return []
        return [] if made is None else [made]

    def _convert(self, packet: av.Packet) -> av.Packet | None:
        found = self._decoder.decode2(packet)
        lines = [line for line in found or () if isinstance(line, AssSubtitle) and line.ass]
        if not lines:
            return None
        text = lines[0].ass + b"".join(b"\\N" + line.dialogue for line in lines[1:])
        made = self._encoder.encode_subtitle(SubtitleSet.create(text, 0, packet.duration or 0))
        made.pts = made.dts = packet.pts
        made.duration, made.time_base = packet.duration, packet.time_base
        made.stream, made.is_keyframe = self.stream, True
        return made


MAX_CHANNELS = {"libmp3lame": 2, "vorbis": 2, "wmav1": 2, "wmav2": 2, "mp2": 2, "ac3": 6, "aac": 8}


MAX_SILENT_GAP_SECONDS = 2 * 3600
"""Longest gap that is filled with silence; longer ones come from damaged timestamps."""


class AudioTranscoder(CopiedStream):
    """Decodes the packets of an audio stream and encodes them with another codec at the same times."""

    def __init__(
        self,
        container: av.container.OutputContainer,
        template: AudioStream,
        encoder: str,
        untimed: Container[str] = (),
    ) -> None:
        """Add the stream.

        Args:
            untimed: codecs whose sound must start at 0 and continue without a gap.
        """
        channels = min(template.layout.nb_channels, MAX_CHANNELS.get(encoder, 8))
        layout = {1: "mono", 2: "stereo"}.get(channels, template.layout.name)
        codec = av.Codec(encoder, "w")
        rate = _choose_rate(template.rate, codec.audio_rates or [])
        self._decoder = AudioDecoder(template, rate, layout)
        self._rate, self._has_times = rate, codec.canonical_name not in untimed
        self._encoder = AudioEncoder(
            container, encoder, rate, layout, from_zero=not self._has_times, keep_gaps=self._has_times
        )
        super().__init__(self._encoder.stream)
        self.loss = self._decoder.loss

    def packets(self, packet: av.Packet | None) -> list[av.Packet]:
        """Transcode a packet; damaged samples are replaced by silence."""
        made: list[av.Packet] = []
        for seconds, samples in self._decoder.samples(packet):
            if not self._has_times and seconds > self._encoder.end + MAX_SILENT_GAP_SECONDS:
                self.loss.seconds += samples.shape[1] / self._rate
            else:
                made += self._encoder.packets(samples, seconds)
        return made

    def flush(self) -> list[av.Packet]:
        """Flush decoder and encoder."""
        return self.packets(None) + self._encoder.flush()

    def make_sample(self, packet: av.Packet) -> list[av.Packet]:
        """Return silence: the decoder must not decode a packet twice."""
        silence = np.zeros((self._encoder.stream.layout.nb_channels, DEFAULT_FRAME_SIZE), np.float32)
        return self._encoder.packets(silence, 0.0) + self._encoder.flush()


def _choose_rate(rate: int, allowed: list[int]) -> int:
    """Return the rate if allowed, else the lowest one above it, else the highest.

    >>> _choose_rate(44100, [8000, 48000])
    48000
    """
    if not allowed or rate in allowed:
        return rate
    return min((other for other in allowed if other >= rate), default=max(allowed))
