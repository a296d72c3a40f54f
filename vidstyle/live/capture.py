"""Takes pictures from a source, and gets the source back when it is lost."""

from __future__ import annotations

import time
from collections.abc import Callable
from fractions import Fraction

from vidstyle.errors import DeviceError
from vidstyle.live.lasting import Lasting
from vidstyle.live.newest import Newest
from vidstyle.media.audio import Heard
from vidstyle.media.capture.input import Captured, LiveInput, LiveSource

FIRST_SECONDS = 10.0
"""How long a source that was opened may take to its first picture."""
STALL_SECONDS = 2.0
"""A source that gives nothing for so long is said to be waited for, though it is not lost yet."""


class Capture(Lasting[LiveInput]):
    """The newest picture of a source.

    Attributes:
        pictures: where it lies.
        codec, rate, sample_aspect, has_sound: of the source, once the first picture is there.
    """

    meanwhile = "the last picture is held"

    def __init__(self, source: LiveSource, hear: Callable[[Heard], None]) -> None:
        """`hear`: is given every piece of sound, in the capturing thread."""
        super().__init__(source, "capture")
        self._hear = hear
        self.pictures: Newest[Captured] = Newest()
        self.codec = ""
        self.has_sound = False
        self.rate: Fraction | None = None
        self.sample_aspect: Fraction | None = None

    @property
    def state(self) -> str:
        """One of "running", "waiting" (for the source) and "ended"."""
        if self.ended:
            return "ended"
        fresh = self._last is not None and time.monotonic() - self._last < STALL_SECONDS
        return "running" if fresh and self._lost is None else "waiting"

    @property
    def failure(self) -> DeviceError | None:
        """That it was opened long ago and no picture has come yet, or None."""
        if self._opened is None or self._last or time.monotonic() - self._opened < FIRST_SECONDS:
            return None
        return DeviceError(self._source.name, f"gave no picture in {FIRST_SECONDS:g} s")

    def close(self, seconds: float) -> None:
        """End; a thread that hangs in a driver is left to itself."""
        self.pictures.close()
        super().close(seconds)

    def _take(self, opened: LiveInput) -> None:
        self.codec, self.sample_aspect = opened.codec, opened.sample_aspect
        self.rate = self.rate or opened.rate
        self.has_sound = opened.has_sound
        for item in opened:
            if isinstance(item, Heard):
                self._hear(item)
            else:
                self._note(item.time)
                self.pictures.put(item)

    def _finish(self) -> None:
        self.pictures.close()
