"""A target with a thread of its own, so that a slow or broken one holds up no other."""

from __future__ import annotations

import logging
import threading
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable
from typing import Protocol

from vidstyle.errors import VidstyleError
from vidstyle.live.clock import MONOTONIC, Clock
from vidstyle.live.latest import DropOldestQueue
from vidstyle.live.meter import LatencyMeter
from vidstyle.live.target import LiveFrame
from vidstyle.media.audio import AudioChunk

MIN_RETRY_SECONDS, MAX_RETRY_SECONDS = 0.25, 2.0
"""Delay before a lost target is opened again: at first, and at most."""
STALL_SECONDS = 2.0
"""Duration of a write after which the state of a target is "stalled"."""
CLOSE_SECONDS = 2.0
"""Time that closing a target may take; a reader that does not read is abandoned."""
MAX_AUDIO_CHUNKS = 200
"""Chunks of sound that may wait, a few seconds."""

log = logging.getLogger("vidstyle")


class Sink(Protocol):
    """An open target that frames are written to."""

    def write(self, frame: LiveFrame, number: int) -> None:
        """Write a frame; raises VidstyleError when the target is lost."""

    def push_audio(self, chunk: AudioChunk) -> None:
        """Write sound, or ignore it."""

    def close(self) -> None:
        """Finish the output."""


class TargetThread(ABC):
    """Base class of targets with a thread; see `Target`.

    Attributes:
        delivered, repeated: number of frames that were written, and written again.
        error: the exception that ended it for good, or None.
    """

    capacity = 1
    """Number of frames that may wait."""

    def __init__(
        self,
        name: str,
        open_sink: Callable[[LiveFrame], Sink],
        meter: LatencyMeter,
        reconnects: bool = False,
        clock: Clock = MONOTONIC,
    ) -> None:
        """`reconnects`: whether to open the target again when it is lost."""
        self.name = name
        self.delivered = self.repeated = 0
        self.error: VidstyleError | None = None
        self._open_sink, self._meter, self._reconnects, self._clock = open_sink, meter, reconnects, clock
        self._frames: DropOldestQueue[LiveFrame] = DropOldestQueue(self.capacity, clock)
        self._audio: deque[AudioChunk] = deque(maxlen=MAX_AUDIO_CHUNKS)
        self._sink: Sink | None = None
        self._latest: LiveFrame | None = None
        self._write_began: float | None = None
        self._ended = False
        self._retry_time, self._retry_delay = 0.0, MIN_RETRY_SECONDS
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"vidstyle to {name}", daemon=True)

    @property
    def dropped(self) -> int:
        """Number of frames that were dropped for newer ones."""
        return self._frames.dropped

    @property
    def state(self) -> str:
        """One of "running", "stalled", "reconnecting", "failed" and "closed"."""
        if self.error is not None:
            return "failed"
        if self._ended:
            return "closed"
        if self._sink is None:
            return "reconnecting"
        began = self._write_began
        return "stalled" if began is not None and self._clock.now() - began > STALL_SECONDS else "running"

    def start(self, first: LiveFrame) -> None:
        """Open the target for frames like this one; raises VidstyleError if that fails."""
        self._sink = self._open_sink(first)
        self._thread.start()

    def offer(self, frame: LiveFrame) -> None:
        """See Target."""
        self._frames.put(frame)

    def push_audio(self, chunk: AudioChunk) -> None:
        """Queue sound, to be written after the next frame."""
        self._audio.append(chunk)

    def close(self) -> None:
        """See Target."""
        self._closing.set()
        self._frames.close()
        if self._thread.ident is not None:
            self._thread.join(CLOSE_SECONDS)

    @abstractmethod
    def _deliver(self, sink: Sink, frame: LiveFrame | None) -> None:
        """Write a frame; None: none has arrived within `_timeout`."""

    def _timeout(self) -> float | None:
        """Seconds to wait for a frame; None: without limit."""
        return None

    def _run(self) -> None:
        try:
            while not self._frames.exhausted and self.error is None:
                timeout = self._timeout() if self._sink is not None else MIN_RETRY_SECONDS
                self._step(self._frames.get(timeout))
        finally:
            if self._sink is not None:
                self._attempt(self._sink.close)
                self._sink = None
            self._ended = True

    def _step(self, frame: LiveFrame | None) -> None:
        sink = self._sink
        self._latest = frame or self._latest
        if sink is None:
            if self._latest is not None and not self._closing.is_set():
                self._reopen(self._latest)
        elif frame is not None or not self._closing.is_set():
            self._attempt(lambda: self._deliver(sink, frame))

    def _write(self, sink: Sink, frame: LiveFrame, number: int) -> None:
        self._write_began = self._clock.now()
        sink.write(frame, number)
        while self._audio:
            sink.push_audio(self._audio.popleft())
        self._write_began = None

    def _count(self, frame: LiveFrame) -> None:
        self.delivered += 1
        self._meter.record(frame.captured)

    def _attempt(self, action: Callable[[], None]) -> None:
        try:
            action()
        except VidstyleError as error:
            self._disconnect(error)

    def _disconnect(self, error: VidstyleError) -> None:
        sink, self._sink, self._write_began = self._sink, None, None
        if not self._reconnects:
            self.error = error
            return
        log.warning("%s; it is tried again", error)
        self._retry_delay = MIN_RETRY_SECONDS
        self._retry_time = self._clock.now() + self._retry_delay
        if sink is not None:
            try:
                sink.close()
            except VidstyleError as again:
                log.debug("%s", again)

    def _reopen(self, frame: LiveFrame) -> None:
        if self._clock.now() < self._retry_time:
            return
        try:
            self._sink = self._open_sink(frame)
            log.warning("%s: is back", self.name)
        except VidstyleError as error:
            log.debug("%s", error)
            self._retry_delay = min(2 * self._retry_delay, MAX_RETRY_SECONDS)
            self._retry_time = self._clock.now() + self._retry_delay
