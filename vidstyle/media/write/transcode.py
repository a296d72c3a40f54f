"""Transcodes audio and text subtitles that a container does not hold as they are."""

from __future__ import annotations

from typing import cast

import av
from av.audio.frame import AudioFrame
from av.audio.resampler import AudioResampler
from av.audio.stream import AudioStream
from av.stream import Stream
from av.subtitles.stream import SubtitleStream
from av.subtitles.subtitle import AssSubtitle, SubtitleSet

TEXT_CODECS = ("subrip", "ass", "ssa", "mov_text", "webvtt", "text", "srt")
"""Canonical names of codecs that hold text rather than pictures."""


class CopiedStream:
    """A stream of a source that is carried over into another container.

    Attributes:
        stream: in the new container.
        lost: how many packets could not be decoded.
    """

    stream: Stream
    lost = 0

    def __init__(self, stream: Stream) -> None:
        self.stream = stream

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """The packets of the new stream that a packet of the old one gives."""
        raise NotImplementedError

    def flush(self) -> list[av.Packet]:
        """The packets that are still held back."""
        return []


class SubtitleTranscoder(CopiedStream):
    """Decodes the packets of one subtitle stream and encodes them into another, at the same times."""

    def __init__(
        self, container: av.container.OutputContainer, template: SubtitleStream, encoder: str
    ) -> None:
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


BIT_RATES = {"aac": 96_000, "libopus": 64_000, "libmp3lame": 96_000, "ac3": 96_000, "wmav2": 96_000}
"""Bits a second for each channel; encoders not named here have no use for it, or know better."""
MAX_CHANNELS = {"libmp3lame": 2, "vorbis": 2, "wmav1": 2, "wmav2": 2, "mp2": 2, "ac3": 6, "aac": 8}
FRAME_SIZE = 1024
"""Samples in a frame, for encoders without a frame size of their own."""


def add_audio_stream(
    container: av.container.OutputContainer, encoder: str, rate: int, layout: str, sample_format: str
) -> AudioStream:
    """A new stream with its encoder opened; `sample_format` is for encoders that name none of their own."""
    stream: AudioStream = container.add_stream(encoder, rate=rate)  # type: ignore[call-overload, assignment]
    stream.layout = layout  # type: ignore[assignment, list-item]
    stream.format = (av.Codec(encoder, "w").audio_formats or [sample_format])[0]  # type: ignore[assignment, list-item]
    if encoder in BIT_RATES:
        stream.bit_rate = BIT_RATES[encoder] * stream.layout.nb_channels
    stream.codec_context.open()
    return stream


class AudioTranscoder(CopiedStream):
    """Decodes the packets of one audio stream and encodes them into another, at the same times.

    Attributes:
        stream: the new one.
        lost: how many packets could not be decoded; there is silence in their place.
    """

    stream: AudioStream

    def __init__(self, container: av.container.OutputContainer, template: AudioStream, encoder: str) -> None:
        self._template = template
        channels = min(template.layout.nb_channels, MAX_CHANNELS.get(encoder, 8))
        layout = {1: "mono", 2: "stereo"}.get(channels, template.layout.name)
        rate = _nearest(template.rate, av.Codec(encoder, "w").audio_rates or [])
        self.stream = add_audio_stream(container, encoder, rate, layout, template.format.name)
        self._resampler = self._new_resampler()

    def packets(self, packet: av.Packet) -> list[av.Packet]:
        """The encoded packets that come out when a packet goes in."""
        try:
            frames = cast("list[AudioFrame]", packet.decode())
        except av.FFmpegError:
            self.lost += 1
            return []
        return [made for frame in frames for made in self._encoded(frame)]

    def flush(self) -> list[av.Packet]:
        """Flush decoder, resampler and encoder."""
        made = [packet for last in self._last_frames() for packet in self._encoded(last)]
        made += [packet for frame in self._resampler.resample(None) for packet in self.stream.encode(frame)]
        return made + self.stream.encode(None)

    def _last_frames(self) -> list[AudioFrame]:
        try:
            return self._template.decode(None)
        except (av.FFmpegError, EOFError):
            return []

    def _encoded(self, frame: AudioFrame) -> list[av.Packet]:
        try:
            resampled = self._resampler.resample(frame)
        except ValueError:  # the sound has changed its channels or its rate
            resampled = self._resampler.resample(None)
            self._resampler = self._new_resampler()
            resampled += self._resampler.resample(frame)
        return [packet for part in resampled for packet in self.stream.encode(part)]

    def _new_resampler(self) -> AudioResampler:
        context = self.stream.codec_context
        return AudioResampler(
            format=context.format,
            layout=context.layout,
            rate=context.sample_rate,
            frame_size=context.frame_size or FRAME_SIZE,
            # Gaps, where packets were lost, become silence; otherwise all that follows would come early.
            options={"async": "1"},
        )


def _nearest(rate: int, allowed: list[int]) -> int:
    """The rate itself if allowed, else the lowest above it, else the highest.

    >>> _nearest(44100, [8000, 48000])
    48000
    """
    if not allowed or rate in allowed:
        return rate
    return min((other for other in allowed if other >= rate), default=max(allowed))
