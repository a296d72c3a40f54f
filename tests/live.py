"""What the tests of live sessions share: sources in real time, sessions in a thread, and waiting."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction

import av
import pytest

from vidstyle.errors import DeviceError
from vidstyle.live import hot_swap
from vidstyle.live.control import Controls
from vidstyle.live.options import LiveOptions, TargetContext
from vidstyle.live.session import LiveSession, LiveSummary
from vidstyle.live.target import LiveFrame, Target
from vidstyle.media.capture.input import LiveSource
from vidstyle.media.capture.sources import GeneratedPicture
from vidstyle.style import load_style

LONG = 20.0
"""Seconds after which a test gives up: far more than anything takes, for the machine may be busy."""
SMALL = (160, 90)
POSTER = {"format": 1, "name": "few", "background": [{"block": "luma_posterize", "levels": 3}]}


def generated(rate: int = 30, size: tuple[int, int] = SMALL) -> LiveSource:
    """A small moving picture in real time."""
    return GeneratedPicture(size, Fraction(rate))


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

    def offer(self, frame: LiveFrame) -> None:
        self.numbers.append(frame.number)
        self.captured.append(frame.captured)
        self.arrived.append(time.monotonic())
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
        self._session = LiveSession(source, self.controls, makers, options)
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
    return lambda setting: target  # type: ignore[return-value]


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
