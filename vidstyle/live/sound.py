"""The sound of a session: the source's own, or that of a microphone in its place."""

from __future__ import annotations

from collections.abc import Callable

from vidstyle.live.listening import Listening
from vidstyle.live.setting import LiveOptions
from vidstyle.media.audio import Heard


class Sound:
    """Chooses what is passed on."""

    def __init__(self, options: LiveOptions, hear: Callable[[Heard], None]) -> None:
        """`hear`: is given every piece of sound, in the thread that takes it."""
        microphone = options.microphone if options.sound else None
        self._wanted, self._hear = options.sound, hear
        self._listening = Listening(microphone, hear) if microphone else None

    def heard(self, heard: Heard) -> None:
        """The source gives this."""
        if self._listening is None:
            self._hear(heard)

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
