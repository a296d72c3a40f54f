"""Live sources by name: cameras, screens, streams, files, pipes and the test picture."""

from __future__ import annotations

import os
import select
import stat
import sys
import threading
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import BinaryIO, cast

import av

from vidstyle.errors import DeviceError, InputError
from vidstyle.media.capture.camera import Camera, Screen
from vidstyle.media.capture.input import LiveInput, LiveSource
from vidstyle.media.capture.monotonic import Clock
from vidstyle.media.options import RawVideo
from vidstyle.media.read.open import is_url, open_media, redact_url

POLL_SECONDS = 0.2
"""Interval at which a wait for data checks whether to stop."""


class Pipe:
    """A file descriptor whose reads return the available bytes without waiting for a full block."""

    def __init__(self, descriptor: int, stopping: threading.Event) -> None:
        self._descriptor, self._stopping = descriptor, stopping

    def read(self, size: int) -> bytes:
        """Read up to `size` bytes; none at the end, or when `stopping` is set."""
        while os.name == "posix" and not select.select([self._descriptor], [], [], POLL_SECONDS)[0]:
            if self._stopping.is_set():
                return b""
        return os.read(self._descriptor, size)


class NamedPipe(Pipe):
    """A named pipe (FIFO), which this object opens and closes."""

    def __init__(self, path: str, stopping: threading.Event) -> None:
        # A blocking open would wait for a writer and could not be cancelled.
        super().__init__(os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0)), stopping)

    def __del__(self) -> None:
        os.close(self._descriptor)


NETWORK_TIMEOUT_SECONDS = 5.0
"""Timeout after which a connection without data is reopened."""
LOW_LATENCY_OPTIONS = {"fflags": "nobuffer", "analyzeduration": "1000000", "probesize": "1000000"}
"""Demuxer options: probe one second of a stream instead of five, and do not buffer."""
TEST_SIZE, TEST_RATE = (640, 360), Fraction(30)


@dataclass(frozen=True)
class SourceOptions:
    """How to read a live source.

    Attributes:
        size, rate: requested size and rate of a camera, a screen or the test picture; None: the default.
        loop: restart a file at its end.
        format: the format of "-", as in `ReadOptions`, or a camera's input format.
        raw, raw_rate: size and format of raw video, and its frame rate; None: 30.
    """

    size: tuple[int, int] | None = None
    rate: Fraction | None = None
    loop: bool = False
    format: str | None = None
    raw: RawVideo = RawVideo()
    raw_rate: Fraction | None = None


def resolve_source(text: str, options: SourceOptions) -> LiveSource:
    """Return the source for a command line argument.

    Args:
        text: "camera" or "" for the first camera, a camera's path, number or name, "screen" or
            "screen:DISPLAY", "test", "-" for standard input, a URL, or a file.

    Raises:
        UsageError: the options do not apply to the source.
    """
    size, rate = options.size, options.rate
    if size is not None and min(size) < 1:
        size = None  # -1 and -2 need the aspect ratio, which is known later
    if text == "test":
        return GeneratedPicture(size or TEST_SIZE, rate or TEST_RATE)
    if text == "screen" or text.startswith("screen:"):
        return Screen(text.partition(":")[2], size, rate)
    if text == "-" or _is_pipe(text):
        return PipeSource(text, options)
    if is_url(text):
        return NetworkSource(text)
    if is_file_name(text):
        return FileSource(text, options.loop)
    return Camera("" if text == "camera" else text, size, rate, options.format)


@dataclass(frozen=True)
class GeneratedPicture:
    """A test picture with motion."""

    size: tuple[int, int]
    rate: Fraction
    name: str = "test"
    reconnects: bool = False

    def open(self, stopping: threading.Event, clock: Clock) -> LiveInput:
        """See LiveSource."""
        width, height = self.size
        try:
            container = av.open(f"testsrc2=size={width}x{height}:rate={self.rate}", format="lavfi")
        except (av.FFmpegError, ValueError) as error:
            raise DeviceError("test", f"there is no test picture of {width}x{height}: {error}") from error
        return LiveInput(container, self.name, stopping, clock, paced=True)


@dataclass(frozen=True)
class FileSource:
    """A film, played in real time."""

    name: str
    loop: bool = False
    reconnects: bool = False

    def open(self, stopping: threading.Event, clock: Clock) -> LiveInput:
        """See LiveSource."""
        return LiveInput(
            open_media(self.name), self.name, stopping, clock, paced=True, loop=self.loop, sound=True
        )


@dataclass(frozen=True)
class NetworkSource:
    """A network stream; if its duration is known, it is a film, which is played in real time."""

    url: str
    reconnects: bool = True

    @property
    def name(self) -> str:
        """The URL without passwords and keys."""
        return redact_url(self.url)

    def open(self, stopping: threading.Event, clock: Clock) -> LiveInput:
        """See LiveSource."""
        options = LOW_LATENCY_OPTIONS | ({"rtsp_transport": "tcp"} if self.url.startswith("rtsp") else {})
        asked = clock.now()
        try:
            container = open_media(self.url, allow_url=True, options=options, seconds=NETWORK_TIMEOUT_SECONDS)
        except InputError as error:
            if clock.now() - asked >= NETWORK_TIMEOUT_SECONDS:
                raise InputError(
                    self.name, f"has not answered within {NETWORK_TIMEOUT_SECONDS:g} s"
                ) from error
            if isinstance(error.__cause__, av.ProtocolNotFoundError):
                scheme = self.url.partition(":")[0]
                reason = f"FFmpeg in this build does not support {scheme}"
                raise InputError(self.name, reason, "use RTSP, RTMP or HTTP") from error
            raise InputError(self.name, error.reason, error.remedy) from error
        film = bool(container.duration)
        timeout = None if film else NETWORK_TIMEOUT_SECONDS
        return LiveInput(container, self.name, stopping, clock, paced=film, sound=True, timeout=timeout)


@dataclass(frozen=True)
class PipeSource:
    """The output of another program: standard input, or a named pipe, which may be reopened."""

    name: str
    options: SourceOptions

    @property
    def reconnects(self) -> bool:
        """Whether to reopen the source: a named pipe waits for its next writer."""
        return self.name != "-"

    def open(self, stopping: threading.Event, clock: Clock) -> LiveInput:
        """See LiveSource; a named pipe waits for its writer."""
        options = self.options
        format, raw = options.raw.demuxer(options.format, options.raw_rate or TEST_RATE)
        pipe = Pipe(sys.stdin.fileno(), stopping) if self.name == "-" else NamedPipe(self.name, stopping)
        container = open_media(cast(BinaryIO, pipe), format=format, options=raw)
        return LiveInput(container, self.name, stopping, clock, paced=True, sound=True)


def _is_pipe(text: str) -> bool:
    try:
        return stat.S_ISFIFO(os.stat(text).st_mode)
    except (OSError, ValueError):
        return False


def is_file_name(text: str) -> bool:
    """Whether the argument names a file, existing or not: it has an extension or a folder."""
    if text.startswith("/dev/"):
        return False
    path = Path(text)
    return os.path.exists(path) or bool(path.suffix) or os.sep in text
