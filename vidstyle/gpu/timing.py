"""How long a style takes on a GPU: each pass, the way there, the way back, and whole frames."""

from __future__ import annotations

import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING

from vidstyle.core.picture import Picture
from vidstyle.gpu.context import close_context, open_context
from vidstyle.gpu.cost import result_targets
from vidstyle.gpu.devices import Device
from vidstyle.gpu.nodes import Layout
from vidstyle.gpu.owner import Owner
from vidstyle.gpu.plan import Form, Plan, make_plan
from vidstyle.gpu.runner import Equipment, _arrays_of
from vidstyle.gpu.session import END_SECONDS, LARGEST, Drawn, Request, Session, driver_errors
from vidstyle.gpu.timed_runner import Clock, TimedRunner
from vidstyle.gpu.transfer import Download, Upload
from vidstyle.style import Style
from vidstyle.style.resolve import prepare

if TYPE_CHECKING:
    import moderngl

LEAST_RUNS = 3
MOST_RUNS = 200
"""A query for each pass of each run waits to be read."""
RATE = 25
"""Frames a second that blocks are told which follow a film over time."""


@dataclass(frozen=True)
class GpuTimes:
    """Seconds for each frame.

    Attributes:
        plan: what was run.
        clock: what the passes were timed with.
        passes: of each pass, without transfers: the median.
        upload, download: of the planes alone, waiting for each: the median.
        whole: from picture to picture when the next one is sent before the last has come back: the mean.
    """

    plan: Plan
    clock: Clock
    passes: tuple[float, ...]
    upload: float
    download: float
    whole: float


def time_style(style: Style, picture: Picture, device: Device, form: Form, seconds: float) -> GpuTimes:
    """Time a style on pictures such as this one.

    A software renderer runs compute passes outside of its queues, so that timer queries see nothing of them:
    there each pass is timed from outside.

    Args:
        seconds: about how long to measure the passes, and as long again for whole frames.

    Raises:
        DeviceError: the GPU fails.
        StyleError: the style cannot be used.
    """
    steps = prepare(style, *picture.shape)
    plan = make_plan(style, steps, Layout.of(picture), picture.encoding, False, form)
    clock: Clock = "wall clock" if device.software else "timer queries"
    owner = Owner("vidstyle-timing")
    try:
        parts = owner.submit(_time_parts, plan, picture, device, clock, seconds).result()
    finally:
        owner.end(END_SECONDS)
    return GpuTimes(plan, clock, *parts, _time_whole(style, picture, device, form, seconds))


def median_time(call: Callable[[], object], seconds: float) -> float:
    """The median of as many calls as fit, in seconds; a first one, which prepares, does not count."""
    call()
    times: list[float] = []
    end = time.perf_counter() + seconds
    while len(times) < LEAST_RUNS or time.perf_counter() < end:
        began = time.perf_counter()
        call()
        times.append(time.perf_counter() - began)
    return median(times)


def _time_parts(
    plan: Plan, picture: Picture, device: Device, clock: Clock, seconds: float
) -> tuple[tuple[float, ...], float, float]:
    """Passes, upload and download, on a context of their own."""
    context = open_context(device.index)
    largest = min(device.limits.texture_size, LARGEST)
    try:
        with driver_errors():
            passes = _time_passes(context, plan, picture, largest, clock, seconds)
            upload = _time_upload(context, plan, picture, seconds / 4)
            return passes, upload, _time_download(context, plan, seconds / 4)
    finally:
        close_context(context)


def _time_passes(
    context: moderngl.Context, plan: Plan, picture: Picture, largest: int, clock: Clock, seconds: float
) -> tuple[float, ...]:
    equipment = Equipment(context)
    runner = TimedRunner(equipment, plan, largest, clock)
    try:
        runner.run(picture, 1)
        began = time.perf_counter()
        runner.run(picture, 1)
        once = time.perf_counter() - began
        return runner.run(picture, round(min(max(seconds / once, LEAST_RUNS), MOST_RUNS)))
    finally:
        runner.release()
        equipment.release()


def _time_upload(context: moderngl.Context, plan: Plan, picture: Picture, seconds: float) -> float:
    planes = {name: plane for node in plan.planes for name, plane in _arrays_of(node, picture).items()}
    upload = Upload(context)

    def send() -> None:
        upload.send(planes)
        context.finish()

    try:
        return median_time(send, seconds) if planes else 0.0
    finally:
        upload.release()


def _time_download(context: moderngl.Context, plan: Plan, seconds: float) -> float:
    targets = result_targets(plan)
    textures = [
        context.texture(target.shape[::-1], target.format.components, dtype=target.format.dtype)
        for target in targets
    ]
    wanted = [min(texture.components, 3) for texture in textures]
    download = Download(context)
    try:
        if not textures:
            return 0.0
        return median_time(lambda: download.begin(list(zip(textures, wanted, strict=True))).arrays(), seconds)
    finally:
        download.release()
        for texture in textures:
            texture.release()


def _time_whole(style: Style, picture: Picture, device: Device, form: Form, seconds: float) -> float:
    """The mean time from picture to picture, one late."""
    session = Session(style, device, form)

    def start(number: int) -> Future[Drawn]:
        return session.start(Request(picture, number / RATE, picture.encoding, False))

    def fetch(started: Future[Drawn]) -> None:
        session.fetch(started.result()).result()

    try:
        fetch(start(0))
        before, after = start(1), start(2)
        fetch(before)
        count, began = 0, time.perf_counter()
        while count < LEAST_RUNS or time.perf_counter() < began + seconds:
            before, after = after, start(count + 3)
            fetch(before)
            count += 1
        elapsed = time.perf_counter() - began
        fetch(after)
        return elapsed / count
    finally:
        session.close()
