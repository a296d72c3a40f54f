"""Drivers that deliver no data: they count as lost and are reopened, and nothing blocks."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from functools import partial

import av
import numpy as np
import pytest
from live import BEGIN, FakeClock, Kept, session
from waiting import LONG, eventually

from vidstyle.errors import DeviceError
from vidstyle.live.capture import FIRST_FRAME_SECONDS
from vidstyle.media.capture import input as live_input
from vidstyle.media.capture.camera import find_descriptors, wait_for_input
from vidstyle.media.capture.input import FIRST_FRAME_TIMEOUT_SECONDS, STALL_TIMEOUT_SECONDS, LiveInput
from vidstyle.media.capture.monotonic import Clock

LAVFI = "testsrc2=size=64x48:rate=30"


@contextmanager
def terminal() -> Iterator[tuple[int, str]]:
    """Open a pseudo-terminal, and return one end and the path of the other."""
    near, far = os.openpty()
    try:
        yield near, os.ttyname(far)
    finally:
        os.close(near)
        os.close(far)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells the descriptors of a process")
def test_a_device_is_waited_for_by_its_descriptor():
    """`cat` on a terminal stands for FFmpeg on a camera: what was opened is found, and waited for."""
    stopping, clock = threading.Event(), FakeClock()
    with terminal() as (near, path), ThreadPoolExecutor() as pool, ExitStack() as last:
        last.callback(clock.advance, 1000.0)  # so that no wait outlives a test that fails
        before = find_descriptors(path)
        descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY)
        opened = find_descriptors(path) - before
        assert opened == {descriptor}
        wait = wait_for_input(descriptor, clock)

        def begun() -> Future[bool]:
            """A wait of 0.3 s that has begun, and looks at its clock again and again."""
            looks, found = clock.looks, pool.submit(wait, stopping, 0.3)
            eventually(lambda: clock.looks > looks + 2)
            return found

        found = begun()
        clock.advance(0.29)
        looks = clock.looks
        eventually(lambda: clock.looks > looks + 1)
        assert not found.done()
        clock.advance(0.02)
        assert found.result(LONG) is False
        # From here on the clock stands still.
        found = begun()
        os.write(near, b"a picture\n")
        assert found.result(LONG) is True
        os.read(descriptor, 100)
        found = begun()
        stopping.set()
        assert found.result(LONG) is False
        os.close(descriptor)


def test_only_the_descriptors_of_that_device_are_found():
    with terminal() as (near, path):
        descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY)
        found = find_descriptors(path)
        assert descriptor in found and near not in found
        os.close(descriptor)
    assert find_descriptors("/no/such/device") == set()


@dataclass
class Driver:
    """A camera that gives pictures but in a span of time, in which it holds its readers without an error.

    Attributes:
        silent: the span, in seconds after the clock's beginning.
        tried: when somebody tried to open it, in the same way.
        found: what `look` gave whenever it could not be opened again.
    """

    silent: tuple[float, float]
    name: str = "driver"
    reconnects: bool = True
    tried: list[float] = field(default_factory=list)
    found: list[object] = field(default_factory=list)
    look: Callable[[], object] = str

    def open(self, stopping: threading.Event, clock: Clock) -> LiveInput:
        self.tried.append(clock.now() - BEGIN)
        if len(self.tried) > 1 and self._is_silent(clock):
            self.found.append(self.look())
            raise DeviceError(self.name, "cannot be opened: Input/output error")
        wait = partial(self._wait, clock)
        return LiveInput(av.open(LAVFI, format="lavfi"), self.name, stopping, clock, wait=wait)

    def _is_silent(self, clock: Clock) -> bool:
        return self.silent[0] <= clock.now() - BEGIN < self.silent[1]

    def _wait(self, clock: Clock, stopping: threading.Event, seconds: float) -> bool:
        if not self._is_silent(clock):
            return not clock.wait(stopping, 1 / 30)
        clock.wait(stopping, min(seconds, BEGIN + self.silent[1] - clock.now()))
        return not (stopping.is_set() or self._is_silent(clock))


def test_a_driver_that_falls_silent_is_opened_again(caplog: pytest.LogCaptureFixture):
    """It is lost after 2 s and a picture, and tried after 0.25, 0.5, 1, 1 ... s."""
    driver, kept = Driver((1.0, 7.0)), Kept()

    def look() -> tuple[str, int]:
        """The state of the session's source, and how many threads read it."""
        assert kept.context is not None
        readers = [each for each in threading.enumerate() if each.name == "vidstyle capture"]
        return kept.context.controls.status().source_state, len(readers)

    driver.look = look
    with session(driver, kept, seconds=9.0) as running:
        running.wait()
    lost = 1 + STALL_TIMEOUT_SECONDS + 1 / 30
    assert "has delivered no frame for 2.0 s; the last frame is repeated" in caplog.text
    tries = [lost + 0.25, lost + 0.75, lost + 1.75, lost + 2.75, lost + 3.75, lost + 4.75]
    assert driver.tried == pytest.approx([0.0, *tries], abs=0.05)
    assert "driver: back after 4.8 s" in caplog.text
    taken = np.array(kept.captured) - BEGIN
    gap = np.argmax(np.diff(taken))
    assert taken[gap : gap + 2] == pytest.approx([1.0, tries[-1]], abs=0.1)
    assert len(taken) == pytest.approx((1.0 + 9.0 - tries[-1]) * 30, abs=4)
    assert driver.found == [("waiting", 1)] * (len(tries) - 1)


def test_one_that_never_gives_anything_is_a_device_that_failed():
    driver = Driver((0.0, 100.0))
    with (
        pytest.raises(
            DeviceError, match=f"driver has delivered no frame for {FIRST_FRAME_TIMEOUT_SECONDS:.1f} s"
        ),
        session(driver) as running,
    ):
        running.wait()
    assert running.clock.now() - BEGIN == pytest.approx(FIRST_FRAME_TIMEOUT_SECONDS, abs=0.11)


def test_one_that_holds_its_reader_for_long_is_not_waited_for(monkeypatch: pytest.MonkeyPatch):
    """Inside the driver, where nobody looks at how long it takes."""
    monkeypatch.setattr(live_input, "FIRST_FRAME_TIMEOUT_SECONDS", 100.0)
    with (
        pytest.raises(DeviceError, match=f"driver has delivered no frame for {FIRST_FRAME_SECONDS:g} s"),
        session(Driver((0.0, 100.0))) as running,
    ):
        running.wait()
    assert running.clock.now() - BEGIN == pytest.approx(FIRST_FRAME_SECONDS, abs=0.11)
