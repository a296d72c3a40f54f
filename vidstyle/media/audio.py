"""Audio: decoded into samples, and samples encoded, on the times of their source."""

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

from vidstyle.errors import log

RATE = 48000
"""Samples per second of live audio, which is stereo."""
MAX_SILENCE = 5
"""Gaps up to this many seconds are filled with silence."""
MAX_WAITING = 500
"""Chunks that are kept until the first frame sets the clock: about ten seconds."""
MAX_SAMPLE = 64.0
"""What is beyond this (36 dB over full scale), or no number, is damage; encoders fail on it."""
BIT_RATES = {"aac": 96_000, "libopus": 64_000, "libmp3lame": 96_000, "ac3": 96_000, "wmav2": 96_000}
"""Bits a second for each channel; encoders not named here have no use for it, or know better."""
FRAME_SIZE = 1024
"""Samples in a frame, for encoders without a frame size of their own."""


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
    """What is damaged of a stream: how many packets, and seconds of their time."""

    packets: int = 0
    seconds: float = 0.0

    def __str__(self) -> str:
        packets, time = f"{self.packets} packet{'s' * (self.packets != 1)}", f"{self.seconds:.2f} s"
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
        loss: packets that could not be decoded; its seconds include samples that were no numbers.
    """

    def __init__(self, stream: AudioStream, rate: int = RATE, layout: str = "stereo") -> None:
        self.stream = stream
        self.loss = Loss()
        self._rate, self._layout = rate, layout
        self._end = 0.0
        self._form: tuple[str, str, int] | None = None
        self._resampler = self._new_resampler()

    def samples(self, packet: av.Packet | None) -> Iterator[tuple[float, np.ndarray]]:
        """The samples of a packet, channels x N float32, and when they begin, in seconds of the stream.

        None in place of a packet flushes the decoder. What cannot be decoded is left out and counted.
        """
        for part in self._parts(packet):
            samples = part.to_ndarray()
            damaged = ~(np.abs(samples) < MAX_SAMPLE)
            if damaged.any():
                self.loss.seconds += float(damaged.any(axis=0).sum()) / self._rate
                samples[damaged] = 0
            if part.pts is not None and part.time_base is not None:
                self._end = float(part.pts * part.time_base)
            yield self._end, samples
            self._end += samples.shape[1] / self._rate

    def _parts(self, packet: av.Packet | None) -> list[AudioFrame]:
        try:
            frames = self.stream.decode(packet) if packet is None or packet.size else []
            parts = [part for frame in frames for part in self._resampled(frame)]
            return parts if packet is not None else [*parts, *self._resampler.resample(None)]
        except (av.FFmpegError, ValueError) as error:
            log.debug("sound could not be decoded: %s", error)
            if packet is not None:
                self.loss.add(packet)
            return []

    def _resampled(self, frame: AudioFrame) -> list[AudioFrame]:
        form, rest = (frame.format.name, frame.layout.name, frame.sample_rate), []
        if self._form not in (None, form):  # as broken headers, and broadcasters, change it
            rest, self._resampler = self._resampler.resample(None), self._new_resampler()
        self._form = form
        return rest + self._resampler.resample(frame)

    def _new_resampler(self) -> AudioResampler:
        return AudioResampler(format="fltp", layout=self._layout, rate=self._rate)


class SourceAudio(AudioDecoder):
    """Decodes the audio of a live source, on the clock of its pictures."""

    def __init__(self, stream: AudioStream) -> None:
        super().__init__(stream)
        self._zero: float | None = None
        self._waiting: deque[tuple[float, np.ndarray]] = deque(maxlen=MAX_WAITING)

    def decode(self, packet: av.Packet) -> Iterator[AudioChunk]:
        """The chunks of a packet, once `set_origin` has set the clock."""
        self._waiting.extend(self.samples(packet))
        while self._waiting and self._zero is not None:
            stamp, samples = self._waiting.popleft()
            yield AudioChunk(samples, self._zero + stamp)

    def set_origin(self, stamp: float, time: float) -> None:
        """Set the clock: a frame with this timestamp was captured at `time`; only the first call counts."""
        if self._zero is None:
            self._zero = time - stamp

    def restart(self) -> None:
        """Forget the clock, as timestamps start over; the next frame sets it again."""
        self._waiting.clear()
        self._zero = None


def audio_stream(container: av.container.InputContainer) -> AudioStream | None:
    """The first audio stream of a source that can be decoded, or None."""
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
        rate: int = RATE,
        layout: str = "stereo",
        from_zero: bool = True,
        gaps: bool = True,
    ) -> None:
        """Add the stream, before the container's header is written.

        Args:
            rate, layout: of the samples that will come.
            from_zero: whether it begins at 0, with silence, rather than with the first samples.
            gaps: whether long gaps may be left in the timestamps.
        """
        self.stream: AudioStream = container.add_stream(encoder, rate=rate)  # type: ignore[call-overload, assignment]
        self.stream.layout = layout  # type: ignore[assignment, list-item]
        self.stream.format = (av.Codec(encoder, "w").audio_formats or ["s16"])[0]  # type: ignore[assignment, list-item]
        if encoder in BIT_RATES:
            self.stream.bit_rate = BIT_RATES[encoder] * self.stream.layout.nb_channels
        self.stream.codec_context.open()
        self._rate, self._layout = rate, layout
        self._resampler = self._new_resampler(from_zero)
        self._end, self._begun = 0, False
        self._from_zero, self._gaps = from_zero, gaps

    @property
    def end(self) -> float:
        """When the samples so far end, in seconds from the start of the container."""
        return self._end / self._rate

    def packets(self, samples: np.ndarray, seconds: float) -> list[av.Packet]:
        """Encode samples; gaps are filled with silence.

        Args:
            samples: channels x N, float32.
            seconds: when they begin, from the start of the container; overlapping samples are dropped.
        """
        begin = round(seconds * self._rate)
        if not self._begun and not self._from_zero:
            self._end = begin
        if self._begun and abs(begin - self._end) <= self._rate // 50:  # timestamps jitter, samples do not
            begin = self._end
        samples = samples[:, max(0, self._end - begin) :]
        begin = max(begin, self._end)
        if samples.shape[1] == 0:
            return []
        self._begun = True
        return self._bridge(begin) + self._resampled(samples, begin)

    def flush(self) -> list[av.Packet]:
        """Flush the encoder."""
        return self._encoded(self._resampler.resample(None)) + list(self.stream.encode(None))

    def _bridge(self, begin: int) -> list[av.Packet]:
        """Leave a gap in the timestamps, or fill it in pieces: minutes of silence would take much memory."""
        made: list[av.Packet] = []
        longest = MAX_SILENCE * self._rate
        if self._gaps and begin - self._end > longest:
            made = self._encoded(self._resampler.resample(None))
            self._resampler = self._new_resampler(from_zero=False)
        while not self._gaps and begin - self._end > longest:
            made += self._resampled(
                np.zeros((self.stream.layout.nb_channels, longest), np.float32), self._end
            )
        return made

    def _resampled(self, samples: np.ndarray, begin: int) -> list[av.Packet]:
        self._end = begin + samples.shape[1]
        frame = AudioFrame.from_ndarray(np.ascontiguousarray(samples), "fltp", self._layout)
        frame.sample_rate, frame.pts, frame.time_base = self._rate, begin, Fraction(1, self._rate)
        return self._encoded(self._resampler.resample(frame))

    def _encoded(self, frames: list[AudioFrame]) -> list[av.Packet]:
        return [packet for frame in frames for packet in self.stream.encode(frame)]

    def _new_resampler(self, from_zero: bool) -> AudioResampler:
        """It makes frames of the encoder's size, and fills gaps with silence."""
        context = self.stream.codec_context
        # By default the filter ignores gaps of up to 0.1 s, after which all sound would be early.
        options = {"async": "1", "min_hard_comp": "0.01"} | ({"first_pts": "0"} if from_zero else {})
        return AudioResampler(
            format=context.format,
            layout=self._layout,
            rate=self._rate,
            frame_size=context.frame_size or FRAME_SIZE,
            options=options,
        )
