"""Decode audio into samples and encode samples, with the timestamps of their source."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
import numpy as np
from av.audio.frame import AudioFrame
from av.audio.resampler import AudioResampler
from av.audio.stream import AudioStream

from vidstyle.errors import counted, log

LIVE_SAMPLE_RATE = 48000
"""Samples per second of live audio, which is stereo."""
MAX_SILENCE_SECONDS = 5
"""Longest gap that is filled with silence."""
MAX_WAITING_CHUNKS = 500
"""Maximum number of chunks kept until the first frame sets the clock: about ten seconds."""
MAX_SAMPLE_LEVEL = 64.0
"""Samples above this level (36 dB over full scale) or not finite are damaged; encoders fail on them."""
BIT_RATES = {"aac": 96_000, "libopus": 64_000, "libmp3lame": 96_000, "ac3": 96_000, "wmav2": 96_000}
"""Bits per second and channel; other encoders ignore the setting or have a better default."""
DEFAULT_FRAME_SIZE = 1024
"""Samples in a frame, for encoders that do not define a frame size."""


@dataclass(frozen=True)
class AudioChunk:
    """A block of audio samples.

    Attributes:
        samples: 2 x N, float32, -1..1.
        time: of the first sample, in seconds of `time.monotonic`, as for frames.
    """

    samples: np.ndarray
    time: float


@dataclass
class Loss:
    """Damage of a stream: number of packets, and their duration in seconds."""

    packets: int = 0
    seconds: float = 0.0

    def __str__(self) -> str:
        packets, time = counted(self.packets, "packet"), f"{self.seconds:.2f} s"
        return packets if not self.seconds else f"{packets} ({time})" if self.packets else time

    def add(self, packet: av.Packet) -> None:
        """Count a packet."""
        context: Any = packet.stream.codec_context
        self.packets += 1
        if packet.duration and packet.time_base is not None:
            self.seconds += float(packet.duration * packet.time_base)
        elif packet.stream.type == "audio" and context is not None and context.sample_rate:
            self.seconds += context.frame_size / context.sample_rate


class AudioDecoder:
    """Decodes an audio stream into samples of one rate and one channel layout.

    Attributes:
        stream: the stream.
        loss: packets that could not be decoded; its seconds include samples that are not finite.
    """

    def __init__(self, stream: AudioStream, rate: int = LIVE_SAMPLE_RATE, layout: str = "stereo") -> None:
        self.stream = stream
        self.loss = Loss()
        self._rate, self._layout = rate, layout
        self._end = 0.0
        self._format: tuple[str, str, int] | None = None
        self._resampler = self._new_resampler()

    def samples(self, packet: av.Packet | None) -> Iterator[tuple[float, np.ndarray]]:
        """Yield the start time of samples in seconds of the stream, and the samples: channels x N, float32.

        None instead of a packet flushes the decoder. Packets that cannot be decoded are skipped and counted.
        """
        for part in self._decode_frames(packet):
            samples = part.to_ndarray()
            damaged = ~(np.abs(samples) < MAX_SAMPLE_LEVEL)
            if damaged.any():
                self.loss.seconds += float(damaged.any(axis=0).sum()) / self._rate
                samples[damaged] = 0
            if part.pts is not None and part.time_base is not None:
                self._end = float(part.pts * part.time_base)
            yield self._end, samples
            self._end += samples.shape[1] / self._rate

    def _decode_frames(self, packet: av.Packet | None) -> list[AudioFrame]:
        try:
            frames = self.stream.decode(packet) if packet is None or packet.size else []
            parts = [part for frame in frames for part in self._resample(frame)]
            return parts if packet is not None else [*parts, *self._resampler.resample(None)]
        except (av.FFmpegError, ValueError) as error:
            log.debug("sound could not be decoded: %s", error)
            if packet is not None:
                self.loss.add(packet)
            return []

    def _resample(self, frame: AudioFrame) -> list[AudioFrame]:
        form, rest = (frame.format.name, frame.layout.name, frame.sample_rate), []
        if self._format not in (None, form):  # broken headers and broadcasts change it in mid-stream
            rest, self._resampler = self._resampler.resample(None), self._new_resampler()
        self._format = form
        return rest + self._resampler.resample(frame)

    def _new_resampler(self) -> AudioResampler:
        return AudioResampler(format="fltp", layout=self._layout, rate=self._rate)


class SourceAudio(AudioDecoder):
    """Decodes the audio of a live source, with times on the clock of its frames."""

    def __init__(self, stream: AudioStream) -> None:
        super().__init__(stream)
        self._origin: float | None = None
        self._waiting: deque[tuple[float, np.ndarray]] = deque(maxlen=MAX_WAITING_CHUNKS)

    def decode(self, packet: av.Packet) -> Iterator[AudioChunk]:
        """Yield the chunks of a packet, once `set_origin` has set the clock."""
        self._waiting.extend(self.samples(packet))
        while self._waiting and self._origin is not None:
            stamp, samples = self._waiting.popleft()
            yield AudioChunk(samples, self._origin + stamp)

    def set_origin(self, stamp: float, time: float) -> None:
        """Set the clock: a frame with this timestamp was captured at `time`; only the first call counts."""
        if self._origin is None:
            self._origin = time - stamp

    def restart(self) -> None:
        """Reset the clock when timestamps start again; the next frame sets it."""
        self._waiting.clear()
        self._origin = None


def find_audio_stream(container: av.container.InputContainer) -> AudioStream | None:
    """Return the first audio stream of a source that can be decoded, or None."""
    return next((stream for stream in container.streams.audio if stream.codec_context is not None), None)


class AudioEncoder:
    """An audio stream in a container that is being written.

    Attributes:
        stream: in the container.
    """

    def __init__(
        self,
        container: av.container.OutputContainer,
        encoder: str,
        rate: int = LIVE_SAMPLE_RATE,
        layout: str = "stereo",
        from_zero: bool = True,
        keep_gaps: bool = True,
    ) -> None:
        """Add the stream, before the container's header is written.

        Args:
            rate, layout: of the samples.
            from_zero: whether the stream starts at 0, with silence, instead of at the first samples.
            keep_gaps: whether long gaps stay gaps in the timestamps.
        """
        self.stream: AudioStream = container.add_stream(encoder, rate=rate)  # type: ignore[call-overload, assignment]
        self.stream.layout = layout  # type: ignore[assignment, list-item]
        self.stream.format = (av.Codec(encoder, "w").audio_formats or ["s16"])[0]  # type: ignore[assignment, list-item]
        if encoder in BIT_RATES:
            self.stream.bit_rate = BIT_RATES[encoder] * self.stream.layout.nb_channels
        self.stream.codec_context.open()
        self._rate, self._layout = rate, layout
        self._resampler = self._new_resampler(from_zero)
        self._end, self._has_begun = 0, False
        self._from_zero, self._keep_gaps = from_zero, keep_gaps

    @property
    def end(self) -> float:
        """End of the samples so far, in seconds from the start of the container."""
        return self._end / self._rate

    def packets(self, samples: np.ndarray, seconds: float) -> list[av.Packet]:
        """Encode samples; gaps are filled with silence.

        Args:
            samples: channels x N, float32.
            seconds: start time, from the start of the container; overlapping samples are dropped.
        """
        begin = round(seconds * self._rate)
        if not self._has_begun and not self._from_zero:
            self._end = begin
        if (
            self._has_begun and abs(begin - self._end) <= self._rate // 50
        ):  # timestamps jitter, samples do not
            begin = self._end
        samples = samples[:, max(0, self._end - begin) :]
        begin = max(begin, self._end)
        if samples.shape[1] == 0:
            return []
        self._has_begun = True
        return self._bridge(begin) + self._resample(samples, begin)

    def flush(self) -> list[av.Packet]:
        """Flush the encoder."""
        return self._encode(self._resampler.resample(None)) + list(self.stream.encode(None))

    def _bridge(self, begin: int) -> list[av.Packet]:
        """Leave a gap in the timestamps, or fill it in parts: minutes of silence would need much memory."""
        made: list[av.Packet] = []
        longest = MAX_SILENCE_SECONDS * self._rate
        if self._keep_gaps and begin - self._end > longest:
            made = self._encode(self._resampler.resample(None))
            self._resampler = self._new_resampler(from_zero=False)
        while not self._keep_gaps and begin - self._end > longest:
            made += self._resample(np.zeros((self.stream.layout.nb_channels, longest), np.float32), self._end)
        return made

    def _resample(self, samples: np.ndarray, begin: int) -> list[av.Packet]:
        self._end = begin + samples.shape[1]
        frame = AudioFrame.from_ndarray(np.ascontiguousarray(samples), "fltp", self._layout)
        frame.sample_rate, frame.pts, frame.time_base = self._rate, begin, Fraction(1, self._rate)
        return self._encode(self._resampler.resample(frame))

    def _encode(self, frames: list[AudioFrame]) -> list[av.Packet]:
        return [packet for frame in frames for packet in self.stream.encode(frame)]

    def _new_resampler(self, from_zero: bool) -> AudioResampler:
        """Create a resampler that returns frames of the encoder's size and fills gaps with silence."""
        context = self.stream.codec_context
        # By default the filter ignores gaps of up to 0.1 s, and all later sound would be early.
        options = {"async": "1", "min_hard_comp": "0.01"} | ({"first_pts": "0"} if from_zero else {})
        return AudioResampler(
            format=context.format,
            layout=self._layout,
            rate=self._rate,
            frame_size=context.frame_size or DEFAULT_FRAME_SIZE,
            options=options,
        )
