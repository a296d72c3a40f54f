"""The sound of a session: the source's own, or that of a microphone in its place."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np

from vidstyle.errors import DeviceError
from vidstyle.live.capture import ReconnectingSource
from vidstyle.live.options import LiveOptions
from vidstyle.media.audio import RATE, AudioChunk
from vidstyle.media.capture.microphone import Microphone, SoundInput


class AudioRouter:
    """Chooses what is passed on."""

    def __init__(self, options: LiveOptions, on_audio: Callable[[AudioChunk], None]) -> None:
        """`on_audio`: is given every piece of sound, in the thread that takes it."""
        microphone = options.microphone if options.sound else None
        self._wanted, self._on_audio = options.sound, on_audio
        self._listening = MicrophoneCapture(microphone, on_audio) if microphone else None

    def push_audio(self, chunk: AudioChunk) -> None:
        """The source gives this."""
        if self._listening is None:
            self._on_audio(chunk)

    def start(self) -> None:
        """Begin to listen."""
        if self._listening is not None:
            self._listening.start()

    def wait(self, source_has_sound: bool) -> bool:
        """Whether there will be sound.

        Raises:
            DeviceError: the microphone is missing, busy, or gives none.
        """
        if self._listening is None:
            return source_has_sound and self._wanted
        self._listening.wait()
        return True

    def close(self, seconds: float) -> None:
        """End; a thread that hangs in a driver is left to itself."""
        if self._listening is not None:
            self._listening.close(seconds)


FIRST_SECONDS = 5.0
"""How long a microphone that was opened may take to its first sound."""
SILENCE_SECONDS = 0.1
"""How long a piece of silence is."""


class MicrophoneCapture(ReconnectingSource[SoundInput]):
    """The sound of a microphone, without a gap."""

    meanwhile = "there is silence"

    def __init__(self, microphone: Microphone, on_audio: Callable[[AudioChunk], None]) -> None:
        """`on_audio`: is given every piece of sound, in a thread of its own."""
        super().__init__(microphone, "microphone")
        self._on_audio = on_audio
        self._end = 0.0
        self._begun = threading.Event()

    def wait(self) -> None:
        """Wait for its first sound.

        Raises:
            DeviceError: it is missing, busy, or gives none.
        """
        heard = self._begun.wait(FIRST_SECONDS)
        if self.error is not None:
            raise self.error
        if not heard:
            raise DeviceError(self._source.name, f"gave no sound in {FIRST_SECONDS:g} s")

    def _take(self, opened: SoundInput) -> None:
        for chunk in opened:
            self._note(chunk.time)
            self._pass_on(chunk)

    def _pause(self, seconds: float) -> None:
        """Wait, with silence up to now; targets would wait for sound otherwise."""
        until = time.monotonic() + seconds
        while not self._stopping.wait(SILENCE_SECONDS) and time.monotonic() < until:
            missing = round((time.monotonic() - self._end) * RATE)
            self._pass_on(AudioChunk(np.zeros((2, max(0, missing)), np.float32), self._end))

    def _pass_on(self, chunk: AudioChunk) -> None:
        self._end = chunk.time + chunk.samples.shape[1] / RATE
        self._on_audio(chunk)
        self._begun.set()

    def _finish(self) -> None:
        self._begun.set()
