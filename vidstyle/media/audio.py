"""Audio of live sources: decoded from a source, and encoded into each target."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
import numpy as np
from av.audio.resampler import AudioResampler

from vidstyle.media.write.transcode import FRAME_SIZE, add_audio_stream

log = logging.getLogger("vidstyle")

RATE = 48000
"""Samples per second; audio is resampled to this rate in stereo."""
MAX_SILENCE = 5
"""Gaps up to this many seconds are filled with silence."""
MAX_WAITING = 500
"""Chunks that are kept until the first frame sets the clock: about ten seconds."""


@dataclass(frozen=True)
class AudioChunk:
    """A block of audio samples.

    Attributes:
        samples: 2 x N, float32, -1..1.
        time: of the first sample, in seconds of `time.monotonic`, as for frames.
    """

    samples: np.ndarray
    time: float


class AudioDecoder:
    """Decodes the audio of a source.

    Attributes:
        stream: the audio stream, or None if the source has none.
    """

    def __init__(self, container: av.container.InputContainer) -> None:
        streams = [each for each in container.streams.audio if each.codec_context is not None]
        self.stream = streams[0] if streams else None
        self._resampler = _resampler("fltp", 0)
        self._zero: float | None = None
        self._waiting: deque[tuple[float, np.ndarray]] = deque(maxlen=MAX_WAITING)

    def decode(self, packet: av.Packet) -> Iterator[AudioChunk]:
        """The chunks of a packet, once `set_origin` has set the clock."""
        self._waiting.extend(self.samples(packet))
        while self._waiting and self._zero is not None:
            stamp, samples = self._waiting.popleft()
            yield AudioChunk(samples, self._zero + stamp)

    def samples(self, packet: av.Packet) -> Iterator[tuple[float, np.ndarray]]:
        """The samples of a packet, 2 x N, and their timestamps in seconds of the source's clock."""
        try:
            frames: list[Any] = list(packet.decode()) if packet.size else []
        except av.FFmpegError as error:
            log.debug("sound could not be decoded: %s", error)
            frames = []
        for frame in frames:
            try:
                resampled = self._resampler.resample(frame)
            except ValueError:  # the channel layout or the sample rate has changed
                self._resampler = _resampler("fltp", 0)
                resampled = self._resampler.resample(frame)
            for part in resampled:
                if part.pts is not None and part.time_base is not None:
                    yield float(part.pts * part.time_base), part.to_ndarray()

    def set_origin(self, stamp: float, time: float) -> None:
        """Set the clock: a frame with this timestamp was captured at `time`; only the first call counts."""
        if self._zero is None:
            self._zero = time - stamp

    def restart(self) -> None:
        """Forget the clock, as timestamps start over; the next frame sets it again."""
        self._waiting.clear()
        self._zero = None


class AudioEncoder:
    """An audio stream in a container that is being written."""

    def __init__(self, container: av.container.OutputContainer, encoder: str) -> None:
        """Add the stream, before the container's header is written."""
        self._stream = add_audio_stream(container, encoder, RATE, "stereo", "s16")
        context = self._stream.codec_context
        self._resampler = _resampler(context.format, context.frame_size or FRAME_SIZE)
        self._end, self._begun = 0, False

    def packets(self, samples: np.ndarray, seconds: float) -> list[av.Packet]:
        """Encode samples; gaps are filled with silence.

        Args:
            samples: 2 x N, float32.
            seconds: when they begin, from the start of the container; overlapping samples are dropped.
        """
        begin = round(seconds * RATE)
        if self._begun and abs(begin - self._end) <= RATE // 50:  # timestamps jitter, samples do not
            begin = self._end
        samples = samples[:, max(0, self._end - begin) :]
        begin = max(begin, self._end)
        if samples.shape[1] == 0:
            return []
        self._begun = True
        made = self._bridge() if begin - self._end > MAX_SILENCE * RATE else []
        self._end = begin + samples.shape[1]
        frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(samples), "fltp", "stereo")
        frame.sample_rate, frame.pts, frame.time_base = RATE, begin, Fraction(1, RATE)
        return made + self._encoded(self._resampler.resample(frame))

    def _bridge(self) -> list[av.Packet]:
        """Leave a gap in the timestamps: minutes of silence would all be encoded at once."""
        made = self._encoded(self._resampler.resample(None))
        context = self._stream.codec_context
        self._resampler = _resampler(context.format, context.frame_size or FRAME_SIZE, from_zero=False)
        return made

    def flush(self) -> list[av.Packet]:
        """Flush the encoder."""
        return self._encoded(self._resampler.resample(None)) + list(self._stream.encode(None))

    def _encoded(self, frames: list[Any]) -> list[av.Packet]:
        return [packet for frame in frames for packet in self._stream.encode(frame)]


def _resampler(format: Any, frame_size: int, from_zero: bool = True) -> AudioResampler:
    """A resampler to stereo at `RATE`. With a frame size, for an encoder, it fills gaps with silence."""
    # By default the filter ignores gaps of up to 0.1 s, after which all sound would be early.
    options = {"async": "1", "min_hard_comp": "0.01"} if frame_size else {}
    if frame_size and from_zero:
        options["first_pts"] = "0"
    return AudioResampler(
        format=format, layout="stereo", rate=RATE, frame_size=frame_size or None, options=options
    )
