"""Shared by the tests of live sessions: sources, an injected clock, sessions, and waiting."""

from __future__ import annotations

import itertools
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache

import av
import pytest

from vidstyle.errors import DeviceError
from vidstyle.live import hot_swap
from vidstyle.live.control import Controls, LiveOptions
from vidstyle.live.meter import MONOTONIC, Clock
from vidstyle.live.session import LiveSession, LiveSummary
from vidstyle.live.target import LiveFrame, Target, TargetContext
from vidstyle.media.capture.input import CapturedFrame, LiveInput, LiveSource
from vidstyle.media.capture.sources import GeneratedPicture
from vidstyle.style import load_style

LONG = 20.0
"""Seconds after which a test gives up: far more than anything takes, for the machine may be busy."""
SMALL = (160, 90)
POSTER = {"format": 1, "name": "few", "background": [{"block": "luma_posterize", "levels": 3}]}


def live_command(*arguments: str) -> list[str]:
    """The program as a command, to be run in a process of its own."""
    return [sys.executable, "-m", "vidstyle", "live", *arguments]


def generated(rate: int = 30, size: tuple[int, int] = SMALL) -> LiveSource:
    """A small moving picture in real time."""
    return GeneratedPicture(size, Fraction(rate))


class FakeClock(Clock):
    """Time that passes only when somebody says so."""

    def __init__(self) -> None:
        self._now = 1000.0

    def now(self) -> float:
        return self._now

    def advance(self, seconds: float) -> None:
        self._now += seconds

    def wait(self, event: threading.Event, seconds: float) -> bool:
        deadline = self._now + seconds
        while not event.is_set() and self._now < deadline:
            event.wait(0.001)
        return event.is_set()

    def wait_for(
        self, condition: threading.Condition, predicate: Callable[[], bool], seconds: float | None
    ) -> bool:
        deadline = float("inf") if seconds is None else self._now + seconds
        while not predicate() and self._now < deadline:
            condition.wait(0.001)
        return predicate()


@cache
def _frames(size: tuple[int, int]) -> list[av.VideoFrame]:
    with av.open(f"testsrc2=size={size[0]}x{size[1]}:rate=10:duration=6", format="lavfi") as container:
        return [frame.reformat(format="yuv420p") for frame in container.decode(video=0)]


@dataclass
class Stepped:
    """A moving picture by a clock of its own: a second passes for `rate` pictures that are taken."""

    rate: Fraction = Fraction(30)
    size: tuple[int, int] = SMALL
    name: str = "stepped"
    reconnects: bool = False
    clock: FakeClock = field(default_factory=FakeClock)
    taken: Callable[[], int] = lambda: 0

    codec = "rawvideo"
    sample_aspect = None
    has_sound = False

    def open(self, stopping: threading.Event) -> LiveInput:
        self._stopping = stopping
        return self  # type: ignore[return-value]

    def __iter__(self) -> Iterator[CapturedFrame]:
        for number, native in enumerate(itertools.cycle(_frames(self.size)), 1):
            self.clock.advance(float(1 / self.rate))
            yield CapturedFrame(native, self.clock.now())
            while self.taken() < number:
                if self._stopping.wait(0.0005):
                    return

    def close(self) -> None: ...


@dataclass
class Kept:
    """A target that keeps what it is offered: numbers, times and the newest picture."""

    name: str = "kept"
    state: str = "running"
    numbers: list[int] = field(default_factory=list)
    captured: list[float] = field(default_factory=list)
    arrived: list[float] = field(default_factory=list)
    newest: av.VideoFrame | None = None
    closed: int = 0
    clock: Clock = MONOTONIC

    def offer(self, frame: LiveFrame) -> None:
        self.numbers.append(frame.number)
        self.captured.append(frame.captured)
        self.arrived.append(self.clock.now())
        self.newest = frame.video

    def close(self) -> None:
        self.closed += 1


class Running:
    """A session in a thread of its own."""

    def __init__(
        self,
        source: LiveSource,
        makers: Sequence[Callable[[TargetContext], Target]],
        style: object,
        options: LiveOptions,
    ) -> None:
        self.controls = Controls(load_style(style), ["plain", "poster", "newsprint"])  # type: ignore[arg-type]
        self.stop = threading.Event()
        self.summary: LiveSummary | None = None
        self.error: BaseException | None = None
        clock = source.clock if isinstance(source, Stepped) else MONOTONIC
        self._session = LiveSession(source, self.controls, makers, options, clock)
        if isinstance(source, Stepped):
            source.taken = lambda: self._session._frames
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        try:
            self.summary = self._session.run(self.stop)
        except BaseException as error:
            self.error = error

    def end(self) -> LiveSummary:
        """Stop it and return how it went."""
        self.stop.set()
        return self.wait()

    def wait(self) -> LiveSummary:
        """Let it come to its own end."""
        self._thread.join(LONG)
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
    **options: object,
) -> Iterator[Running]:
    """A running session; at the end all its threads have to be gone."""
    before = set(threading.enumerate())
    makers = [target if not hasattr(target, "offer") else _handing(target) for target in targets]
    running = Running(source, makers, style, LiveOptions(device="cpu", **options))  # type: ignore[arg-type]
    try:
        yield running
    finally:
        running.stop.set()
        running._thread.join(LONG)
    eventually(lambda: not own_threads() - before)


def _handing(target: object) -> Callable[[TargetContext], Target]:
    return lambda context: target  # type: ignore[return-value]


def own_threads() -> set[threading.Thread]:
    """The threads that we have started and that still run."""
    return {thread for thread in threading.enumerate() if thread.name.startswith("vidstyle")}


def eventually(fact: Callable[[], object], what: object = "") -> None:
    """Wait until something is so; fail if that never comes."""
    deadline = time.monotonic() + LONG
    while not fact():
        assert time.monotonic() < deadline, what() if callable(what) else what or "it never came to be"
        time.sleep(0.01)


def before_opening(name: str, do: Callable[[], None], monkeypatch: pytest.MonkeyPatch) -> None:
    """Let something happen whenever a live session makes the style of this name ready."""
    original = hot_swap.open_renderer

    def open_renderer(style: object, *given: object, **named: object) -> object:
        if getattr(style, "name", "") == name:
            do()
        return original(style, *given, **named)  # type: ignore[arg-type]

    monkeypatch.setattr(hot_swap, "open_renderer", open_renderer)


def refuse() -> None:
    """What a device that has gone says."""
    raise DeviceError("gpu:7", "is gone")
