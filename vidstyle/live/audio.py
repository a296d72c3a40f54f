"""Sound from a microphone, in place of that of the source."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np

from vidstyle.errors import DeviceError
from vidstyle.live.capture import ReconnectingSource
from vidstyle.live.timing import MONOTONIC, Clock
from vidstyle.media.audio import RATE, AudioChunk
from vidstyle.media.capture.microphone import AudioInput, Microphone

FIRST_CHUNK_SECONDS = 5.0
"""Time that a microphone may take from opening to its first sound."""
SILENCE_SECONDS = 0.1
"""Duration of a chunk of silence."""


class MicrophoneCapture(ReconnectingSource[AudioInput]):
    """Captures a microphone without gaps: while it is lost, silence is delivered."""

    substitute = "there is silence"

    def __init__(
        self, microphone: Microphone, push_audio: Callable[[AudioChunk], None], clock: Clock = MONOTONIC
    ) -> None:
        """`push_audio`: receives the sound, in a thread of its own."""
        super().__init__(microphone, "microphone", clock)
        self._push_audio = push_audio
        self._end = 0.0
        self._started = threading.Event()

    def wait(self) -> None:
        """Wait for the first sound.

        Raises:
            DeviceError: the microphone is missing or busy, or delivers nothing.
        """
        started = self._clock.wait(self._started, FIRST_CHUNK_SECONDS)
        if self.error is not None:
            raise self.error
        if not started:
            raise DeviceError(self._source.name, f"gave no sound in {FIRST_CHUNK_SECONDS:g} s")

    def _read(self, opened: AudioInput) -> None:
        for chunk in opened:
            self._received(chunk.time)
            self._deliver(chunk)

    def _wait(self, seconds: float) -> None:
        """Wait, delivering silence up to the present: targets would wait for sound otherwise."""
        until = self._clock.now() + seconds
        while not self._clock.wait(self._stopping, SILENCE_SECONDS) and self._clock.now() < until:
            missing = round((self._clock.now() - self._end) * RATE)
            self._deliver(AudioChunk(np.zeros((2, max(0, missing)), np.float32), self._end))

    def _deliver(self, chunk: AudioChunk) -> None:
        self._end = chunk.time + chunk.samples.shape[1] / RATE
        self._push_audio(chunk)
        self._started.set()

    def _finish(self) -> None:
        self._started.set()
