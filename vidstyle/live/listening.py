"""Takes sound from a microphone, and silence while that is lost."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np

from vidstyle.errors import DeviceError
from vidstyle.live.lasting import Lasting
from vidstyle.media.audio import RATE, Heard
from vidstyle.media.capture.microphone import Microphone, SoundInput

FIRST_SECONDS = 5.0
"""How long a microphone that was opened may take to its first sound."""
SILENCE_SECONDS = 0.1
"""How long a piece of silence is."""


class Listening(Lasting[SoundInput]):
    """The sound of a microphone, without a gap."""

    meanwhile = "there is silence"

    def __init__(self, microphone: Microphone, hear: Callable[[Heard], None]) -> None:
        """`hear`: is given every piece of sound, in a thread of its own."""
        super().__init__(microphone, "microphone")
        self._hear = hear
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
        for heard in opened:
            self._note(heard.time)
            self._pass_on(heard)

    def _pause(self, seconds: float) -> None:
        """Wait, with silence up to now; targets would wait for sound otherwise."""
        until = time.monotonic() + seconds
        while not self._stopping.wait(SILENCE_SECONDS) and time.monotonic() < until:
            missing = round((time.monotonic() - self._end) * RATE)
            self._pass_on(Heard(np.zeros((2, max(0, missing)), np.float32), self._end))

    def _pass_on(self, heard: Heard) -> None:
        self._end = heard.time + heard.samples.shape[1] / RATE
        self._hear(heard)
        self._begun.set()

    def _finish(self) -> None:
        self._begun.set()
