"""Targets with separate threads, so that a slow or broken target does not delay others."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from fractions import Fraction
from math import floor
from typing import Protocol

from vidstyle.errors import OutputError, VidstyleError, log
from vidstyle.live.latest import DropOldestQueue
from vidstyle.live.target import LiveFrame, TargetContext
from vidstyle.media.audio import AudioChunk

MIN_RETRY_SECONDS, MAX_RETRY_SECONDS = 0.25, 2.0
"""Delay before a lost target is opened again: at first, and at most."""
STALL_SECONDS = 2.0
"""Duration of a write after which the state of a target is "stalled"."""
CLOSE_SECONDS = 2.0
"""Time that closing a stream may take; a reader that does not read is abandoned."""
FINISH_SECONDS = 60.0
"""Time that finishing a file may take, on a busy machine or a slow disk; after it the file has failed."""
MAX_AUDIO_CHUNKS = 200
"""Chunks of sound that may wait, a few seconds."""


class Sink(Protocol):
    """An open target that frames are written to.

    Attributes:
        needs_every: whether frames have no timestamps, so that all must be written.
    """

    needs_every: bool

    def write(self, frame: LiveFrame, number: int) -> None:
        """Write a frame; raises VidstyleError when the target is lost."""

    def push_audio(self, chunk: AudioChunk) -> None:
        """Write sound, or ignore it."""

    def close(self) -> None:
        """Finish the output."""


class TargetThread:
    """A target to which a thread writes every frame that it is offered; see `Target`.

    Attributes:
        delivered, repeated: number of frames that were written, and written again.
        error: the exception that ended it for good, or None.
    """

    def __init__(
        self,
        name: str,
        open_sink: Callable[[], Sink],
        context: TargetContext,
        reconnects: bool = False,
        capacity: int = 1,
        finish_seconds: float | None = None,
    ) -> None:
        """Open the target and start the thread.

        Args:
            reconnects: whether to open the target again when it is lost.
            capacity: number of frames that may wait.
            finish_seconds: time after which a target that is still being closed has failed; None: it is
                abandoned after `CLOSE_SECONDS`, which is no error.

        Raises:
            VidstyleError: it cannot be opened.
        """
        self.name = name
        self.delivered = self.repeated = 0
        self.error: VidstyleError | None = None
        self._open_sink, self._reconnects, self._finish_seconds = open_sink, reconnects, finish_seconds
        self._meter, self._clock = context.meter, context.clock
        self._frames: DropOldestQueue[LiveFrame] = DropOldestQueue(capacity, context.clock)
        self._audio: deque[AudioChunk] = deque(maxlen=MAX_AUDIO_CHUNKS)
        self._sink: Sink | None = open_sink()
        self._write_began: float | None = None
        self._lost: VidstyleError | None = None
        self._ended = False
        self._retry_time, self._retry_delay = 0.0, MIN_RETRY_SECONDS
        self._closing = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"vidstyle to {name}", daemon=True)
        self._thread.start()

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
        self._thread.join(self._finish_seconds or CLOSE_SECONDS)
        if self._finish_seconds and self._thread.is_alive():
            reason = f"was not finished within {self._finish_seconds:g} s"
            self.error = self.error or OutputError(self.name, reason, "see its partial file")

    def _deliver(self, sink: Sink, frame: LiveFrame | None) -> None:
        """Write a frame; None: no frame arrived within `_timeout`."""
        if frame is not None:
            self._write(sink, frame, self.delivered)
            self._count(frame)

    def _timeout(self) -> float | None:
        """Seconds to wait for a frame; None: without limit."""
        return None

    def _run(self) -> None:
        try:
            while not self._frames.exhausted and self.error is None:
                timeout = self._timeout() if self._sink is not None else MIN_RETRY_SECONDS
                self._step(self._frames.get(timeout))
        finally:
            self._end()
            self._ended = True

    def _end(self) -> None:
        """Close the target; a network stream may be lost at its end, if it was ever there."""
        sink, self._sink = self._sink, None
        try:
            if sink is not None:
                sink.close()
        except VidstyleError as error:
            self._lost = error
        if not self._reconnects or not self.delivered:
            self.error = self.error or self._lost

    def _step(self, frame: LiveFrame | None) -> None:
        sink = self._sink
        if sink is None:
            if not self._closing.is_set() and self._clock.now() >= self._retry_time:
                self._reopen()
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
        self._lost = error
        if not self._reconnects:
            self.error = error
            return
        log.warning("%s; reconnecting", error)
        self._retry_delay = MIN_RETRY_SECONDS
        self._retry_time = self._clock.now() + self._retry_delay
        if sink is not None:
            try:
                sink.close()
            except VidstyleError as again:
                log.debug("%s", again)

    def _reopen(self) -> None:
        try:
            self._sink = self._open_sink()
            log.warning("%s: reconnected", self.name)
        except VidstyleError as error:
            log.debug("%s", error)
            self._retry_delay = min(2 * self._retry_delay, MAX_RETRY_SECONDS)
            self._retry_time = self._clock.now() + self._retry_delay


class ConstantRateTarget(TargetThread):
    """A stream at a constant rate: if no new frame arrives in time, the last one is repeated."""

    def __init__(
        self, name: str, open_sink: Callable[[], Sink], context: TargetContext, reconnects: bool = False
    ) -> None:
        self._pacer = FramePacer(context.rate)
        self._last: LiveFrame | None = None
        self._waiting: LiveFrame | None = None
        """A frame that came too early and has not been written."""
        self._early = 0
        super().__init__(name, open_sink, context, reconnects)  # starts the thread

    @property
    def dropped(self) -> int:
        """Number of frames that were dropped for newer ones, or because they came too early."""
        return super().dropped + self._early

    def _timeout(self) -> float | None:
        return self._pacer.timeout(self._clock.now())

    def _deliver(self, sink: Sink, frame: LiveFrame | None) -> None:
        before = self._pacer.last
        number = self._pacer.slot(self._clock.now())
        if number is None:
            self._early += frame is not None
            self._waiting = frame or self._waiting
            self._last = frame or self._last  # should the next be late, this one is repeated in its place
            return
        for missing in range(before + 1, number if sink.needs_every else 0):
            self._repeat(sink, missing)
        if frame is None:
            self._repeat(sink, number)
        else:
            self._write(sink, frame, number)
            self._last = frame
            self._count(frame)
        self._waiting = None

    def _repeat(self, sink: Sink, number: int) -> None:
        if self._last is not None:
            self._write(sink, self._last, number)
            self.repeated += 1

    def _end(self) -> None:
        """Write the last frame even if it came too early: no other one replaces it."""
        sink, frame = self._sink, self._waiting
        if sink is not None and frame is not None:
            self._attempt(lambda: self._write_early(sink, frame))
        super()._end()

    def _write_early(self, sink: Sink, frame: LiveFrame) -> None:
        self._write(sink, frame, self._pacer.last + 1)
        self._early -= 1
        self._count(frame)


EARLY_TOLERANCE = 0.75
"""Share of a frame's duration by which it may miss its slot, so that jitter drops and repeats nothing."""
MAX_GAP = 1.0
"""Seconds without a write after which the reader counts as stalled; slots continue from there."""


class FramePacer:
    """Assigns frames to the slots of a constant rate.

    Attributes:
        last: number of the slot that was filled last; -1 before the first.
    """

    def __init__(self, rate: Fraction) -> None:
        self._rate = float(rate)
        self._start: float | None = None
        self.last = -1

    def slot(self, now: float) -> int | None:
        """The slot of a frame that arrives now, or None if it is too early and is dropped.

        Args:
            now: in seconds, of any monotonic clock.
        """
        next_slot = self.last + 1
        if self._start is None or now - self._time(next_slot) > MAX_GAP:
            self._start = now - next_slot / self._rate
        position = (now - self._start) * self._rate
        if position < next_slot - EARLY_TOLERANCE:
            return None
        self.last = max(next_slot, floor(position))
        return self.last

    def timeout(self, now: float) -> float | None:
        """Seconds until the last frame must be repeated, or None before the first."""
        return None if self._start is None else max(0.0, self._time(self.last + 1 + EARLY_TOLERANCE) - now)

    def _time(self, slot: float) -> float:
        assert self._start is not None
        return self._start + slot / self._rate
