"""A target with a thread of its own, so that a slow or broken one holds up nobody else."""

from __future__ import annotations

import logging
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from typing import Protocol

from vidstyle.errors import VidstyleError
from vidstyle.live.latest import DropOldestQueue
from vidstyle.live.meter import Meter
from vidstyle.live.target import LiveFrame
from vidstyle.media.audio import AudioChunk

FIRST_WAIT, MAX_WAIT = 0.25, 2.0
"""Seconds before a lost target is tried again: at first, and at most."""
STALL_SECONDS = 2.0
CLOSE_SECONDS = 2.0
"""How long the end of a target may take; a reader that does not read is not waited for."""
MAX_HEARD = 200
"""Pieces of sound that may wait: a few seconds."""

log = logging.getLogger("vidstyle")


class Sink(Protocol):
    """Something open that pictures are written to."""

    def write(self, frame: LiveFrame, number: int) -> None:
        """Write a picture; raises VidstyleError when the target is lost."""

    def push_audio(self, chunk: AudioChunk) -> None:
        """Write sound, or leave it."""

    def close(self) -> None:
        """End it well."""


class TargetThread(ABC):
    """What all targets with a thread have in common; see `Target`.

    Attributes:
        delivered, repeated: how many frames were written, and written again.
        error: why it ended for good, or None.
    """

    room = 1

    def __init__(
        self, name: str, open_sink: Callable[[LiveFrame], Sink], meter: Meter, reconnects: bool
    ) -> None:
        """`reconnects`: whether to open it again when it is lost."""
        self.name = name
        self.delivered = self.repeated = 0
        self.error: VidstyleError | None = None
        self._open_sink, self._meter, self._reconnects = open_sink, meter, reconnects
        self._frames: DropOldestQueue[LiveFrame] = DropOldestQueue(self.room)
        self._audio: deque[AudioChunk] = deque(maxlen=MAX_HEARD)
        self._sink: Sink | None = None
        self._latest: LiveFrame | None = None
        self._writing: float | None = None
        self._ended = False
        self._retry, self._wait = 0.0, FIRST_WAIT
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"vidstyle to {name}", daemon=True)

    @property
    def dropped(self) -> int:
        """Frames that were left out, newer ones being there."""
        return self._frames.dropped

    @property
    def state(self) -> str:
        """How it is, in a word."""
        if self.error is not None:
            return "failed"
        if self._ended:
            return "closed"
        if self._sink is None:
            return "reconnecting"
        writing = self._writing
        return "stalled" if writing is not None and time.monotonic() - writing > STALL_SECONDS else "running"

    def start(self, first: LiveFrame) -> None:
        """Open it for pictures like this one; raises VidstyleError if that cannot be done."""
        self._sink = self._open_sink(first)
        self._thread.start()

    def offer(self, frame: LiveFrame) -> None:
        """See Target."""
        self._frames.put(frame)

    def push_audio(self, chunk: AudioChunk) -> None:
        """Take sound, to be written before the next picture; without a place for it it is thrown away."""
        self._audio.append(chunk)

    def close(self) -> None:
        """See Target."""
        self._closing.set()
        self._frames.close()
        if self._thread.ident is not None:
            self._thread.join(CLOSE_SECONDS)

    @abstractmethod
    def _deliver(self, sink: Sink, frame: LiveFrame | None) -> None:
        """Write a frame that has come; None: none has come in time."""

    def _patience(self) -> float | None:
        """Seconds to wait for a frame; None: as long as it takes."""
        return None

    def _run(self) -> None:
        try:
            while not self._frames.over and self.error is None:
                patience = self._patience() if self._sink is not None else FIRST_WAIT
                self._step(self._frames.take(patience))
        finally:
            if self._sink is not None:
                self._guarded(self._sink.close)
                self._sink = None
            self._ended = True

    def _step(self, frame: LiveFrame | None) -> None:
        sink = self._sink
        self._latest = frame or self._latest
        if sink is None:
            if self._latest is not None and not self._closing.is_set():
                self._reopen(self._latest)
        elif frame is not None or not self._closing.is_set():
            self._guarded(lambda: self._deliver(sink, frame))

    def _write(self, sink: Sink, frame: LiveFrame, number: int) -> None:
        self._writing = time.monotonic()
        sink.write(frame, number)
        while self._audio:
            sink.push_audio(self._audio.popleft())
        self._writing = None

    def _count(self, frame: LiveFrame) -> None:
        self.delivered += 1
        self._meter.delivered(frame.captured)

    def _guarded(self, work: Callable[[], None]) -> None:
        try:
            work()
        except VidstyleError as error:
            self._lose(error)

    def _lose(self, error: VidstyleError) -> None:
        sink, self._sink, self._writing = self._sink, None, None
        if not self._reconnects:
            self.error = error
            return
        log.warning("%s; it is tried again", error)
        self._retry, self._wait = time.monotonic() + FIRST_WAIT, FIRST_WAIT
        if sink is not None:
            try:
                sink.close()
            except VidstyleError as again:
                log.debug("%s", again)

    def _reopen(self, frame: LiveFrame) -> None:
        if time.monotonic() < self._retry:
            return
        try:
            self._sink = self._open_sink(frame)
            log.warning("%s: is back", self.name)
        except VidstyleError as error:
            log.debug("%s", error)
            self._wait = min(2 * self._wait, MAX_WAIT)
            self._retry = time.monotonic() + self._wait
