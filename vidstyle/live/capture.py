"""Capture of a source or a microphone in a separate thread, with reconnection."""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable
from contextlib import closing
from fractions import Fraction
from typing import Generic

import numpy as np

from vidstyle.errors import DeviceError, VidstyleError, log
from vidstyle.live.latest import DropOldestQueue
from vidstyle.media.audio import LIVE_SAMPLE_RATE, AudioChunk
from vidstyle.media.capture.input import CapturedFrame, CaptureSource, LiveInput, LiveSource, T
from vidstyle.media.capture.microphone import AudioInput, Microphone
from vidstyle.media.capture.monotonic import MONOTONIC, Clock

MIN_RETRY_SECONDS, MAX_RETRY_SECONDS = 0.25, 1.0
"""Delay before a lost source is opened again: at first, and at most."""

PushAudio = Callable[[AudioChunk], None]


class ReconnectingSource(ABC, Generic[T]):
    """Keeps a source open for the duration of a session.

    Attributes:
        error: the exception that ended it before it delivered anything, or None.
        ended: whether it has ended for good.
    """

    purpose = substitute = ""
    """The name of the thread, and the substitute while the source is lost, for the log."""

    def __init__(self, source: CaptureSource[T], push_audio: PushAudio, clock: Clock) -> None:
        """`push_audio`: receives the sound, in the capturing thread."""
        self.error: BaseException | None = None
        self.ended = False
        self._source, self._push_audio, self._clock = source, push_audio, clock
        self._stopping = threading.Event()
        self._last: float | None = None
        self._lost: float | None = None
        self._opened: float | None = None
        self._thread = threading.Thread(target=self._run, name=f"vidstyle {self.purpose}", daemon=True)

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self, timeout: float) -> None:
        """Stop; a thread that hangs in a driver is abandoned after `timeout` seconds."""
        self._stopping.set()
        if self._thread.ident is not None:
            self._thread.join(timeout)

    @abstractmethod
    def _read(self, opened: T) -> None:
        """Read until the end; calls `_received` for each item."""

    def _finish(self) -> None:
        """Called once, after the end."""

    def _wait(self, seconds: float) -> None:
        """Wait before the source is opened again."""
        self._clock.wait(self._stopping, seconds)

    def _run(self) -> None:
        try:
            self._reconnect()
        except BaseException as error:  # raised again in the session's own thread
            self.error = error
        finally:
            self.ended = True
            self._finish()

    def _reconnect(self) -> None:
        delay = MIN_RETRY_SECONDS
        while not self._stopping.is_set():
            before = self._last
            try:
                self._open_and_read()
                reason = f"{self._source.name}: has ended"
            except VidstyleError as error:
                if self._last is None:
                    raise
                reason = str(error)
            if not self._source.reconnects or self._stopping.is_set():
                return
            delay = MIN_RETRY_SECONDS if self._last != before else min(2 * delay, MAX_RETRY_SECONDS)
            if self._lost is None and self._last is not None:
                log.warning("%s; %s until it is back", reason, self.substitute)
                self._lost = self._clock.now()
            self._wait(delay)

    def _open_and_read(self) -> None:
        with closing(self._source.open(self._stopping, self._clock)) as opened:
            self._opened = self._clock.now()
            self._read(opened)

    def _received(self, time: float) -> None:
        """Record that something was captured at this time."""
        if self._lost is not None:
            log.warning("%s: back after %.1f s", self._source.name, self._clock.now() - self._lost)
            self._lost = None
        self._last = time


FIRST_FRAME_SECONDS = 10.0
"""Time that a source may take from opening to its first frame."""
STALL_SECONDS = 2.0
"""Time without a frame after which the state of a source is "waiting", though it is not lost yet."""


class Capture(ReconnectingSource[LiveInput]):
    """Captures the newest frame of a source.

    Attributes:
        frames: the queue that holds it.
        codec, rate, sample_aspect, has_sound: of the source, known with the first frame.
    """

    purpose, substitute = "capture", "the last frame is repeated"

    def __init__(self, source: LiveSource, push_audio: PushAudio, clock: Clock = MONOTONIC) -> None:
        super().__init__(source, push_audio, clock)
        self.frames: DropOldestQueue[CapturedFrame] = DropOldestQueue(clock=self._clock)
        self.codec = ""
        self.has_sound = False
        self.rate: Fraction | None = None
        self.sample_aspect: Fraction | None = None

    @property
    def state(self) -> str:
        """One of "running", "waiting" (for the source) and "ended"."""
        if self.ended:
            return "ended"
        fresh = self._last is not None and self._clock.now() - self._last < STALL_SECONDS
        return "running" if fresh and self._lost is None else "waiting"

    @property
    def startup_error(self) -> DeviceError | None:
        """An error if the source has been open for long without a frame, else None."""
        if self._opened is None or self._last or self._clock.now() - self._opened < FIRST_FRAME_SECONDS:
            return None
        return DeviceError(self._source.name, f"has delivered no frame for {FIRST_FRAME_SECONDS:g} s")

    def close(self, timeout: float) -> None:
        """Stop; a thread that hangs in a driver is abandoned after `timeout` seconds."""
        self.frames.close()
        super().close(timeout)

    def _read(self, opened: LiveInput) -> None:
        self.codec, self.sample_aspect = opened.codec, opened.sample_aspect
        self.rate = self.rate or opened.rate
        self.has_sound = opened.has_sound
        for item in opened:
            if isinstance(item, AudioChunk):
                self._push_audio(item)
            else:
                self._received(item.time)
                self.frames.put(item)

    def _finish(self) -> None:
        self.frames.close()


FIRST_CHUNK_SECONDS = 5.0
"""Time that a microphone may take from opening to its first sound."""
SILENCE_SECONDS = 0.1
"""Duration of a chunk of silence."""


class MicrophoneCapture(ReconnectingSource[AudioInput]):
    """Captures a microphone without gaps: while it is lost, silence is delivered."""

    purpose, substitute = "microphone", "there is silence"

    def __init__(self, microphone: Microphone, push_audio: PushAudio, clock: Clock = MONOTONIC) -> None:
        super().__init__(microphone, push_audio, clock)
        self._end = 0.0
        self._started = threading.Event()

    def wait(self) -> None:
        """Wait for the first sound.

        Raises:
            DeviceError: the microphone is missing or busy, or delivers nothing.
        """
        started = self._clock.wait(self._started, FIRST_CHUNK_SECONDS)
        if self.error is not None:
            raise self.error
        if not started:
            raise DeviceError(self._source.name, f"has delivered no sound for {FIRST_CHUNK_SECONDS:g} s")

    def _read(self, opened: AudioInput) -> None:
        for chunk in opened:
            self._received(chunk.time)
            self._deliver(chunk)

    def _wait(self, seconds: float) -> None:
        """Wait, delivering silence up to the present: targets would wait for sound otherwise."""
        until = self._clock.now() + seconds
        while not self._clock.wait(self._stopping, SILENCE_SECONDS) and self._clock.now() < until:
            missing = round((self._clock.now() - self._end) * LIVE_SAMPLE_RATE)
            self._deliver(AudioChunk(np.zeros((2, max(0, missing)), np.float32), self._end))

    def _deliver(self, chunk: AudioChunk) -> None:
        self._end = chunk.time + chunk.samples.shape[1] / LIVE_SAMPLE_RATE
        self._push_audio(chunk)
        self._started.set()

    def _finish(self) -> None:
        self._started.set()
