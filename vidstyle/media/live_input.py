"""An open live source: the newest pictures as they come, each with the moment it was taken."""

from __future__ import annotations

import logging
import os
import select
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Protocol

import av

from vidstyle.errors import InputError
from vidstyle.media.streams import choose_stream, frame_rate

log = logging.getLogger("vidstyle")

OWN_CLOCK_SECONDS = 2.0
"""A camera's stamp this little before now is of our own clock, and says when the picture was taken."""
WAKE_SECONDS = 0.2
"""How often a wait for data looks whether it is still wanted."""
LEAP_SECONDS = 10.0
"""A stamp this far from its predecessor begins a new count."""


@dataclass(frozen=True)
class Captured:
    """A picture as it came.

    Attributes:
        native: as decoded.
        time: when it was taken, in seconds of `time.monotonic`.
    """

    native: av.VideoFrame
    time: float


class LiveSource(Protocol):
    """Something that can be opened, and opened again after it was lost."""

    @property
    def name(self) -> str:
        """What it is, for people."""

    @property
    def lasting(self) -> bool:
        """Whether it may come back after its end."""

    def open(self, stopping: threading.Event) -> LiveInput:
        """Begin to take pictures.

        Args:
            stopping: once it is set, the wait for a first picture is over, and so is what was opened.

        Raises:
            DeviceError: a camera or screen that is missing or busy.
            InputError: anything else that cannot be read.
        """


class LiveInput:
    """Decodes one video stream with no frame held back. Iterate over it once, in one thread.

    Attributes:
        codec: what it is decoded with.
        rate: frames a second, if the source says so.
        sample_aspect: width of a pixel for each unit of height, or None.
    """

    def __init__(
        self,
        container: av.container.InputContainer,
        name: str,
        stopping: threading.Event,
        *,
        paced: bool = False,
        loop: bool = False,
        stamped: bool = False,
    ) -> None:
        """Begin with an open container, which `close` closes.

        Args:
            stopping: ends the iteration; from any thread.
            paced: give frames out no faster than their stamps say.
            loop: begin again at the end.
            stamped: the driver stamps pictures by the monotonic clock when it takes them.

        Raises:
            InputError: there is no video in it.
        """
        self._container, self._name = container, name
        self._stream = choose_stream(container, name)
        context: Any = self._stream.codec_context
        if not paced:
            # Threads that work on several frames at once would each hold one back.
            context.thread_type = "SLICE"
            context.flags |= av.codec.context.Flags.low_delay
        self._context = context
        self._loop, self._stamped = loop, stamped
        self._pace = Pace() if paced else None
        self._stopping = stopping
        self.codec = str(context.name)
        self.rate = frame_rate(self._stream)
        self.sample_aspect = Fraction(self._stream.sample_aspect_ratio or 0) or None

    def __iter__(self) -> Iterator[Captured]:
        """Frames until the source ends.

        Raises:
            InputError: the source was lost.
        """
        while not self._stopping.is_set():
            try:
                yield from self._once()
                if not self._loop:
                    return
                self._container.seek(0)
            except (av.FFmpegError, OSError) as error:
                reason = getattr(error, "strerror", None) or error
                raise InputError(self._name, f"was lost: {reason}") from error
            self._context.flush_buffers()
            if self._pace:
                self._pace.restart()

    def close(self) -> None:
        """Let go of the source; call it when the iteration has ended."""
        self._container.close()

    def _once(self) -> Iterator[Captured]:
        for packet in self._container.demux(self._stream):
            yield from self._decoded(packet)
            if self._stopping.is_set():
                return

    def _decoded(self, packet: av.Packet) -> Iterator[Captured]:
        arrived = time.monotonic()
        try:
            frames = self._context.decode(packet if packet.size else None)
        except av.InvalidDataError as error:  # one frame is lost, not the stream
            log.debug("a packet could not be decoded: %s", error)
            return
        except av.EOFError:
            return
        for frame in frames:
            if self._pace is not None:
                self._stopping.wait(self._pace.until(_seconds(frame)))
                arrived = time.monotonic()
            yield Captured(frame, _taken(frame, arrived) if self._stamped else arrived)


class Pace:
    """The clock of a film that is played at its own speed."""

    def __init__(self) -> None:
        self._zero: float | None = None
        self._last = self._step = self._due = 0.0

    def until(self, stamp: float | None) -> float:
        """Seconds to wait until a frame with this stamp is due; 0 when it is late."""
        now = time.monotonic()
        if stamp is None:
            return 0.0
        if self._zero is None or not -1 < stamp - self._last < LEAP_SECONDS:
            self._zero = max(now, self._due + self._step) - stamp
        elif stamp > self._last:
            self._step = stamp - self._last
        self._last, self._due = stamp, self._zero + stamp
        return max(0.0, self._due - now)

    def restart(self) -> None:
        """The next stamp begins a new count, one step after the last frame."""
        self._zero = None


class Pipe:
    """A file descriptor to read from that gives what is there, rather than waiting to fill a block."""

    def __init__(self, descriptor: int, stopping: threading.Event) -> None:
        self._descriptor, self._stopping = descriptor, stopping

    def read(self, size: int) -> bytes:
        """Up to so many bytes; none at the end, or when it is time to stop."""
        while os.name == "posix" and not select.select([self._descriptor], [], [], WAKE_SECONDS)[0]:
            if self._stopping.is_set():
                return b""
        return os.read(self._descriptor, size)


class NamedPipe(Pipe):
    """A pipe with a place in a folder; the descriptor is its own."""

    def __init__(self, path: str, stopping: threading.Event) -> None:
        # Opened so, it does not wait for a writer where nobody could wake it.
        super().__init__(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), stopping)

    def __del__(self) -> None:
        os.close(self._descriptor)


def _seconds(frame: av.VideoFrame) -> float | None:
    return None if frame.pts is None or frame.time_base is None else float(frame.pts * frame.time_base)


def _taken(frame: av.VideoFrame, arrived: float) -> float:
    """When a frame was taken, by its stamp where that can be."""
    stamp = _seconds(frame)
    return stamp if stamp is not None and 0 <= arrived - stamp < OWN_CLOCK_SECONDS else arrived
