"""Takes from a source in a thread of its own, and gets the source back when it is lost."""

from __future__ import annotations

import logging
import threading
import time
from abc import ABC, abstractmethod
from typing import Generic

from vidstyle.errors import VidstyleError
from vidstyle.media.capture.source import Source, T

FIRST_WAIT, LONGEST_WAIT = 0.25, 1.0
"""Seconds before a lost source is tried again: at first, and at most."""

log = logging.getLogger("vidstyle")


class Lasting(ABC, Generic[T]):
    """One source for as long as a session runs.

    Attributes:
        error: why it never gave anything, or None.
        ended: whether it is over for good.
    """

    meanwhile = ""
    """What there is while it is lost, for people."""

    def __init__(self, source: Source[T], purpose: str) -> None:
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
            if not self._source.lasting or self._stopping.is_set():
                return
            wait = FIRST_WAIT if self._last != before else min(2 * wait, LONGEST_WAIT)
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
