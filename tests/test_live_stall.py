"""Drivers that deliver no data: they count as lost and are reopened, and nothing blocks."""

from __future__ import annotations

import os
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field

import av
import pytest
from live import Kept, eventually, session

from vidstyle.errors import DeviceError
from vidstyle.live import capture
from vidstyle.media.capture import input as live_input
from vidstyle.media.capture.camera import device_descriptors, wait_for_input
from vidstyle.media.capture.input import LiveInput, WaitForFrame

LAVFI = "testsrc2=size=64x48:rate=30"


@contextmanager
def terminal() -> Iterator[tuple[int, str]]:
    """A device of this machine that anybody may open: one end, and the path of the other."""
    near, far = os.openpty()
    try:
        yield near, os.ttyname(far)
    finally:
        os.close(near)
        os.close(far)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells the descriptors of a process")
def test_a_device_is_waited_for_by_its_descriptor():
    """`cat` on a terminal stands for FFmpeg on a camera: what was opened is found, and waited for."""
    stopping = threading.Event()
    with terminal() as (near, path):
        before = device_descriptors(path)
        descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY)
        opened = device_descriptors(path) - before
        assert opened == {descriptor}
        wait = wait_for_input(descriptor)
        begin = time.monotonic()
        assert not wait(stopping, 0.3) and 0.25 < time.monotonic() - begin < 2
        threading.Timer(0.2, os.write, (near, b"a picture\n")).start()
        begin = time.monotonic()
        assert wait(stopping, 5.0) and 0.1 < time.monotonic() - begin < 2
        os.read(descriptor, 100)
        threading.Timer(0.2, stopping.set).start()
        begin = time.monotonic()
        assert not wait(stopping, 5.0) and time.monotonic() - begin < 2
        os.close(descriptor)


def test_only_the_descriptors_of_that_device_are_found():
    with terminal() as (near, path):
        descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY)
        found = device_descriptors(path)
        assert descriptor in found and near not in found
        os.close(descriptor)
    assert device_descriptors("/no/such/device") == set()


@dataclass
class Driver:
    """A camera that gives pictures while `gives` is set, and else holds its readers without an error."""

    name: str = "driver"
    reconnects: bool = True
    opened: int = 0
    gives: threading.Event = field(default_factory=threading.Event)

    def open(self, stopping: threading.Event) -> LiveInput:
        if self.opened and not self.gives.is_set():
            raise DeviceError(self.name, "cannot be opened: Input/output error")
        self.opened += 1
        return LiveInput(av.open(LAVFI, format="lavfi"), self.name, stopping, wait=self._wait())

    def _wait(self) -> WaitForFrame:
        def wait(stopping: threading.Event, seconds: float) -> bool:
            stopping.wait(1 / 30)
            until = time.monotonic() + seconds
            while not self.gives.is_set() and not stopping.is_set() and time.monotonic() < until:
                stopping.wait(0.01)
            return self.gives.is_set() and not stopping.is_set()

        return wait


def test_a_driver_that_falls_silent_is_opened_again(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.setattr(live_input, "STALL_SECONDS", 0.5)
    driver, kept = Driver(), Kept()
    driver.gives.set()
    with session(driver, kept) as running:
        eventually(lambda: len(kept.numbers) > 5)
        driver.gives.clear()
        silent = time.monotonic()
        eventually(lambda: "has delivered no frame for 0.5 s; the last picture is held" in caplog.text)
        assert time.monotonic() - silent < 2.5 and running.controls.status().source_state == "waiting"
        assert sum(thread.name == "vidstyle capture" for thread in threading.enumerate()) == 1
        time.sleep(0.6)
        count, returned = len(kept.numbers), time.monotonic()
        driver.gives.set()
        eventually(lambda: len(kept.numbers) > count + 5)
        assert time.monotonic() - returned < 3 and driver.opened == 2
        running.end()


def test_one_that_never_gives_anything_is_a_device_that_failed(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(live_input, "FIRST_SECONDS", 0.3)
    driver = Driver()
    with (
        pytest.raises(DeviceError, match="driver: has delivered no frame for 0.3 s"),
        session(driver) as running,
    ):
        running.wait()


def test_one_that_holds_its_reader_for_long_is_not_waited_for(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(capture, "FIRST_FRAME_SECONDS", 0.3)
    with pytest.raises(DeviceError, match="driver: gave no picture in 0.3 s"), session(Driver()) as running:
        running.wait()
