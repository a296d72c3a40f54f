"""Sources, targets, injected clocks and sessions for the tests of live."""

from __future__ import annotations

import io
import socket
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction

import av
import pytest
from faults import own_threads
from waiting import LONG, eventually

from vidstyle.errors import DeviceError
from vidstyle.live import hot_swap
from vidstyle.live.control import Controls, LiveOptions
from vidstyle.live.session import LiveSession, LiveSummary
from vidstyle.live.target import LiveFrame, Target, TargetContext
from vidstyle.media.capture.input import LiveSource
from vidstyle.media.capture.monotonic import Clock
from vidstyle.media.capture.sources import GeneratedPicture
from vidstyle.style import load_style

SMALL = (160, 90)
POSTER = {"format": 1, "name": "few", "background": [{"block": "luma_posterize", "levels": 3}]}


def live_command(*arguments: str) -> list[str]:
    """Return the command line of `vidstyle live` for a separate process."""
    return [sys.executable, "-m", "vidstyle", "live", *arguments]


def generated(rate: int = 30, size: tuple[int, int] = SMALL) -> LiveSource:
    """Return a source that generates a small moving picture in real time."""
    return GeneratedPicture(size, Fraction(rate))


class FakeClock(Clock):
    """A clock that advances only on request.

    Attributes:
        looks: number of calls of `now`.
    """

    def __init__(self) -> None:
        self._now = 1000.0
        self.looks = 0

    def now(self) -> float:
        self.looks += 1
        return self._now

    def wall(self) -> float:
        return self._now + 10**9

    def advance(self, seconds: float) -> None:
        self._now += seconds

    def wait(self, event: threading.Event, seconds: float) -> bool:
        return self._wait(event.is_set, seconds, event.wait)

    def wait_for(
        self, condition: threading.Condition, predicate: Callable[[], bool], seconds: float | None
    ) -> bool:
        return self._wait(predicate, float("inf") if seconds is None else seconds, condition.wait)

    def _wait(self, is_over: Callable[[], bool], seconds: float, pause: Callable[[float], object]) -> bool:
        deadline = self._now + seconds
        while not is_over() and self._now < deadline:
            pause(0.001)
        return is_over()


BEGIN = FakeClock().now()
"""Start time of these clocks."""


class SimulatedClock(FakeClock):
    """A clock that jumps to the next deadline as soon as all threads of a session wait.

    A session runs as fast as possible, and everything happens exactly when it is due on any machine.
    Threads left over from earlier sessions are ignored.
    """

    THREADS = tuple(f"vidstyle {name}" for name in ("session", "capture", "microphone", "style", "to "))

    def __init__(self) -> None:
        super().__init__()
        self._waits: dict[threading.Thread, tuple[Callable[[], bool], float]] = {}
        self._others = set(threading.enumerate())
        self._lock = threading.Lock()

    def _wait(self, is_over: Callable[[], bool], seconds: float, pause: Callable[[float], object]) -> bool:
        deadline = self._now + seconds
        with self._lock:
            self._waits[threading.current_thread()] = is_over, deadline
        while not is_over() and self._now < deadline:
            with self._lock:
                self._pass()
            pause(0.001)
        with self._lock:
            del self._waits[threading.current_thread()]
        return is_over()

    def _pass(self) -> None:
        own = set(threading.enumerate()) - self._others
        threads = {each for each in own if each.name.startswith(self.THREADS)}
        moment = min(deadline for _, deadline in self._waits.values())
        is_idle = not any(is_over() for is_over, _ in self._waits.values())
        if threads <= self._waits.keys() and is_idle and self._now < moment < float("inf"):
            self._now = moment


@dataclass
class Kept:
    """A target that records the numbers and times of frames, and keeps the newest picture."""

    name: str = "kept"
    state: str = "running"
    numbers: list[int] = field(default_factory=list)
    captured: list[float] = field(default_factory=list)
    arrived: list[float] = field(default_factory=list)
    newest: av.VideoFrame | None = None
    closed: int = 0
    context: TargetContext | None = None
    """The context with which it was opened, or None."""

    def offer(self, frame: LiveFrame) -> None:
        self.numbers.append(frame.number)
        self.captured.append(frame.captured)
        assert self.context is not None
        self.arrived.append(self.context.clock.now())
        self.newest = frame.video

    def close(self) -> None:
        self.closed += 1


class Running:
    """A session in a separate thread."""

    def __init__(
        self,
        source: LiveSource,
        makers: Sequence[Callable[[TargetContext], Target]],
        style: object,
        options: LiveOptions,
        clock: Clock,
    ) -> None:
        self.controls = Controls(load_style(style), ["plain", "poster", "newsprint"])  # type: ignore[arg-type]
        self.stop = threading.Event()
        self.summary: LiveSummary | None = None
        self.error: BaseException | None = None
        self.clock = clock
        self._session = LiveSession(source, self.controls, makers, options, clock)
        self._thread = threading.Thread(target=self._run, name="vidstyle session", daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            self.summary = self._session.run(self.stop)
        except BaseException as error:
            self.error = error

    def join(self) -> None:
        """Wait for the thread."""
        self._thread.join(LONG)

    def end(self) -> LiveSummary:
        """Stop the session and return its summary."""
        self.stop.set()
        return self.wait()

    def wait(self) -> LiveSummary:
        """Wait until the session ends by itself, and return its summary."""
        self.join()
        assert not self._thread.is_alive()
        if self.error is not None:
            raise self.error
        assert self.summary is not None
        return self.summary


@contextmanager
def session(
    source: LiveSource,
    *targets: Target | Callable[[TargetContext], Target],
    style: object = "plain",
    clock: Clock | None = None,
    **options: object,
) -> Iterator[Running]:
    """Run a session within the block, in simulated time unless a clock is given; all threads must end."""
    before = set(threading.enumerate())
    makers = [target if not hasattr(target, "offer") else _handing(target) for target in targets]
    running = Running(source, makers, style, LiveOptions(device="cpu", **options), clock or SimulatedClock())  # type: ignore[arg-type]
    try:
        yield running
    finally:
        running.stop.set()
        running.join()
    eventually(lambda: not own_threads() - before)


def _handing(target: Kept) -> Callable[[TargetContext], Target]:
    def make(context: TargetContext) -> Target:
        target.context = context
        return target

    return make


def before_opening(name: str, do: Callable[[], None], monkeypatch: pytest.MonkeyPatch) -> None:
    """Call a function whenever a live session prepares the style of this name."""
    original = hot_swap.open_renderer

    def open_renderer(style: object, *given: object, **named: object) -> object:
        if getattr(style, "name", "") == name:
            do()
        return original(style, *given, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(hot_swap, "open_renderer", open_renderer)


def refuse() -> None:
    """Raise the error of a lost device."""
    raise DeviceError("gpu:7", "is gone")


class Receiver:
    """Receives data on a local port, and hangs up on request."""

    def __init__(self, port: int = 0) -> None:
        self._server = socket.create_server(("127.0.0.1", port))
        self.port = int(self._server.getsockname()[1])
        self.content = bytearray()
        self._connection: socket.socket | None = None
        self._thread = threading.Thread(target=self._receive, daemon=True)
        self._thread.start()

    def _receive(self) -> None:
        try:
            self._connection, _ = self._server.accept()
            while part := self._connection.recv(65536):
                self.content += part
        except OSError:
            pass  # hung up

    def finish(self) -> None:
        """Wait until the sender has hung up."""
        self._thread.join(LONG)
        assert not self._thread.is_alive()

    def hang_up(self) -> None:
        for each in (self._connection, self._server):
            if each is not None:
                try:
                    each.shutdown(socket.SHUT_RDWR)
                except OSError:
                    pass  # the other side was first
                each.close()
        self._thread.join(LONG)

    def frames(self) -> int:
        with av.open(io.BytesIO(bytes(self.content)), format="mpegts") as container:
            return sum(1 for _ in container.decode(video=0))
