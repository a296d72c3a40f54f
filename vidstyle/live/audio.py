"""The sound of a session: that of the source, or of a microphone in its place."""

from __future__ import annotations

import threading
from collections.abc import Callable

import numpy as np

from vidstyle.errors import DeviceError
from vidstyle.live.capture import ReconnectingSource
from vidstyle.live.control import LiveOptions
from vidstyle.live.timing import MONOTONIC, Clock
from vidstyle.media.audio import RATE, AudioChunk
from vidstyle.media.capture.microphone import AudioInput, Microphone

PushAudio = Callable[[AudioChunk], None]


class AudioRouter:
    """Routes the sound of the source or of a microphone to the targets."""

    def __init__(self, options: LiveOptions, push_audio: PushAudio, clock: Clock = MONOTONIC) -> None:
        """`push_audio`: receives the sound, in the thread that captures it."""
        microphone = options.microphone if options.sound else None
        self._enabled, self._push_audio = options.sound, push_audio
        self._microphone = MicrophoneCapture(microphone, push_audio, clock) if microphone else None

    def push_source_audio(self, chunk: AudioChunk) -> None:
        """Accept sound of the source."""
        if self._microphone is None:
            self._push_audio(chunk)

    def start(self) -> None:
        """Start to capture."""
        if self._microphone is not None:
            self._microphone.start()

    def wait(self, source_has_sound: bool) -> bool:
        """Wait until it is known whether there will be sound; returns whether.

        Raises:
            DeviceError: the microphone is missing or busy, or delivers nothing.
        """
        if self._microphone is None:
            return source_has_sound and self._enabled
        self._microphone.wait()
        return True

    def close(self, timeout: float) -> None:
        """Stop; a thread that hangs in a driver is abandoned after `timeout` seconds."""
        if self._microphone is not None:
            self._microphone.close(timeout)


FIRST_CHUNK_SECONDS = 5.0
"""Time that a microphone may take from opening to its first sound."""
SILENCE_SECONDS = 0.1
"""Duration of a chunk of silence."""


class MicrophoneCapture(ReconnectingSource[AudioInput]):
    """Captures a microphone without gaps: while it is lost, silence is delivered."""

    substitute = "there is silence"

    def __init__(self, microphone: Microphone, push_audio: PushAudio, clock: Clock = MONOTONIC) -> None:
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
