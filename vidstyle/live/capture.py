"""Takes pictures from a source in a thread of its own, and gets the source back when it is lost."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from fractions import Fraction

from vidstyle.errors import VidstyleError
from vidstyle.live.newest import Newest
from vidstyle.media.live_input import Captured, LiveInput, LiveSource
from vidstyle.media.live_sound import Heard

FIRST_WAIT, LONGEST_WAIT = 0.25, 2.0
"""Seconds before a lost source is tried again: at first, and at most."""
STALL_SECONDS = 2.0
"""A source that gives nothing for so long counts as lost, though it does not say so."""

log = logging.getLogger("vidstyle")


class Capture:
    """The newest picture of a source.

    Attributes:
        pictures: where it lies.
        codec, rate, sample_aspect, has_sound: of the source, once the first picture is there.
        error: why there never was a picture, or None.
    """

    def __init__(self, source: LiveSource, hear: Callable[[Heard], None]) -> None:
        """`hear`: is given every piece of sound, in the capturing thread."""
        self._source, self._hear = source, hear
        self._stopping = threading.Event()
        self._last: float | None = None
        self._lost: float | None = None
        self._opened: float | None = None
        self._ended = False
        self.pictures: Newest[Captured] = Newest()
        self.codec = ""
        self.has_sound = False
        self.rate: Fraction | None = None
        self.sample_aspect: Fraction | None = None
        self.error: BaseException | None = None
        self._thread = threading.Thread(target=self._run, name="vidstyle capture", daemon=True)

    @property
    def state(self) -> str:
        """One of "running", "waiting" (for the source) and "ended"."""
        if self._ended:
            return "ended"
        fresh = self._last is not None and time.monotonic() - self._last < STALL_SECONDS
        return "running" if fresh and self._lost is None else "waiting"

    def gives_nothing(self, seconds: float) -> bool:
        """Whether it was opened so long ago, and no picture has come yet."""
        return self._opened is not None and self._last is None and time.monotonic() - self._opened > seconds

    def start(self) -> None:
        """Begin."""
        self._thread.start()

    def close(self, seconds: float) -> None:
        """End; a thread that hangs in a driver is left to itself."""
        self._stopping.set()
        self.pictures.close()
        if self._thread.ident is not None:
            self._thread.join(seconds)

    def _run(self) -> None:
        try:
            self._keep_going()
        except BaseException as error:  # raised again in the session's own thread
            self.error = error
        finally:
            self._ended = True
            self.pictures.close()

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
            if not self._source.lasting or self._stopping.is_set():
                return
            wait = FIRST_WAIT if self._last != before else min(2 * wait, LONGEST_WAIT)
            self._lose(reason)
            self._stopping.wait(wait)

    def _take_all(self, opened: LiveInput) -> None:
        try:
            self._opened = time.monotonic()
            self.codec, self.sample_aspect = opened.codec, opened.sample_aspect
            self.rate = self.rate or opened.rate
            self.has_sound = opened.has_sound
            for item in opened:
                if isinstance(item, Heard):
                    self._hear(item)
                else:
                    self._note(item.time)
                    self.pictures.put(item)
        finally:
            opened.close()

    def _note(self, now: float) -> None:
        if self._lost is not None:
            log.warning("%s: back after %.1f s", self._source.name, time.monotonic() - self._lost)
            self._lost = None
        self._last = now

    def _lose(self, reason: str) -> None:
        if self._lost is None and self._last is not None:
            log.warning("%s; the last picture is held until it is back", reason)
            self._lost = time.monotonic()
