"""Takes from a source in a thread of its own, and gets the source back when it is lost."""

from __future__ import annotations

import logging
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from fractions import Fraction
from typing import Generic

from vidstyle.errors import DeviceError, VidstyleError
from vidstyle.live.latest import DropOldestQueue
from vidstyle.media.audio import AudioChunk
from vidstyle.media.capture.input import CapturedFrame, CaptureSource, LiveInput, LiveSource, T

FIRST_WAIT, MAX_WAIT = 0.25, 1.0
"""Seconds before a lost source is tried again: at first, and at most."""

log = logging.getLogger("vidstyle")


class ReconnectingSource(ABC, Generic[T]):
    """One source for as long as a session runs.

    Attributes:
        error: why it never gave anything, or None.
        ended: whether it is over for good.
    """

    meanwhile = ""
    """What there is while it is lost, for people."""

    def __init__(self, source: CaptureSource[T], purpose: str) -> None:
        """`purpose`: names the thread."""
        self.error: BaseException | None = None
        self.ended = False
        self._source = source
        self._stopping = threading.Event()
        self._last: float | None = None
        self._lost: float | None = None
        self._opened: float | None = None
        self._thread = threading.Thread(target=self._run, name=f"vidstyle {purpose}", daemon=True)

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def close(self, seconds: float) -> None:
        """End; a thread that hangs in a driver is left to itself."""
        self._stopping.set()
        if self._thread.ident is not None:
            self._thread.join(seconds)

    @abstractmethod
    def _take(self, opened: T) -> None:
        """Take everything until the end; `_note` each."""

    def _finish(self) -> None:
        """Called once, after the end."""

    def _pause(self, seconds: float) -> None:
        """Wait before the source is tried again."""
        self._stopping.wait(seconds)

    def _run(self) -> None:
        try:
            self._keep_going()
        except BaseException as error:  # raised again in the session's own thread
            self.error = error
        finally:
            self.ended = True
            self._finish()

    def _keep_going(self) -> None:
        wait = FIRST_WAIT
        while not self._stopping.is_set():
            before = self._last
            try:
                self._take_all(self._source.open(self._stopping))
                reason = f"{self._source.name}: has ended"
            except VidstyleError as error:
                if self._last is None:
                    raise
                reason = str(error)
            if not self._source.reconnects or self._stopping.is_set():
                return
            wait = FIRST_WAIT if self._last != before else min(2 * wait, MAX_WAIT)
            self._lose(reason)
            self._pause(wait)

    def _take_all(self, opened: T) -> None:
        try:
            self._opened = time.monotonic()
            self._take(opened)
        finally:
            opened.close()

    def _note(self, now: float) -> None:
        """Something has come that was taken now."""
        if self._lost is not None:
            log.warning("%s: back after %.1f s", self._source.name, time.monotonic() - self._lost)
            self._lost = None
        self._last = now

    def _lose(self, reason: str) -> None:
        if self._lost is None and self._last is not None:
            log.warning("%s; %s until it is back", reason, self.meanwhile)
            self._lost = time.monotonic()


FIRST_SECONDS = 10.0
"""How long a source that was opened may take to its first picture."""
STALL_SECONDS = 2.0
"""A source that gives nothing for so long is said to be waited for, though it is not lost yet."""


class Capture(ReconnectingSource[LiveInput]):
    """The newest picture of a source.

    Attributes:
        pictures: where it lies.
        codec, rate, sample_aspect, has_sound: of the source, once the first picture is there.
    """

    meanwhile = "the last picture is held"

    def __init__(self, source: LiveSource, on_audio: Callable[[AudioChunk], None]) -> None:
        """`on_audio`: is given every piece of sound, in the capturing thread."""
        super().__init__(source, "capture")
        self._on_audio = on_audio
        self.pictures: DropOldestQueue[CapturedFrame] = DropOldestQueue()
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
            if isinstance(item, AudioChunk):
                self._on_audio(item)
            else:
                self._note(item.time)
                self.pictures.put(item)

    def _finish(self) -> None:
        self.pictures.close()
