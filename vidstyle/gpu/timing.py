"""Timing of a style on a GPU: each pass, upload, download, and whole frames."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import product
from statistics import median
from typing import Literal

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Picture, PictureLayout
from vidstyle.gpu.compile.explain import result_targets
from vidstyle.gpu.compile.glsl import Form
from vidstyle.gpu.compile.passes import Pass
from vidstyle.gpu.compile.plan import Plan, make_plan
from vidstyle.gpu.compile.tiles import MAX_SIDE
from vidstyle.gpu.device.context import ContextThread, close_context, open_context
from vidstyle.gpu.device.devices import Device
from vidstyle.gpu.device.gpu_resources import GpuResources
from vidstyle.gpu.device.runner import Runner, plane_arrays
from vidstyle.gpu.session import END_SECONDS, GpuSession, InFlightFrame, driver_errors
from vidstyle.style import Style
from vidstyle.style.resolve import resolve

MIN_RUNS = 3
MAX_RUNS = 200
"""Limits on the number of timed runs; each run has one timer query per pass."""
FRAME_RATE = 25
"""Frame rate of the timed film, in frames per second."""


@dataclass(frozen=True)
class GpuTimes:
    """Times per frame, in seconds.

    Attributes:
        plan: the plan that was run.
        clock: the clock of `passes`.
        passes: median time of each pass, without transfers.
        upload, download: median time of transferring only the planes, waiting for each transfer.
        whole: mean time from picture to picture if the next one is uploaded before the last has been
            returned.
    """

    plan: Plan
    clock: TimerKind
    passes: tuple[float, ...]
    upload: float
    download: float
    whole: float


def time_style(style: Style, picture: Picture, device: Device, form: Form, seconds: float) -> GpuTimes:
    """Time a style on pictures like this one.

    A software renderer runs compute passes outside of its queues, where timer queries do not measure them, so
    its passes are timed by the wall clock.

    Args:
        seconds: approximate time for measuring the passes, and again for whole frames.

    Raises:
        DeviceError: the GPU fails.
        StyleError: the style cannot be used.
    """
    steps = resolve(style, *picture.shape)
    plan = make_plan(style, steps, PictureLayout.of(picture), picture.encoding, False, form)
    clock: TimerKind = "wall clock" if device.software else "timer queries"
    thread = ContextThread("vidstyle-timing")
    try:
        parts = thread.submit(_time_parts, plan, picture, device, clock, seconds).result()
    finally:
        thread.end(END_SECONDS)
    return GpuTimes(plan, clock, *parts, _time_whole(style, picture, device, form, seconds))


def median_time(call: Callable[[], object], seconds: float) -> float:
    """Return the median time of all calls that fit into `seconds`, after a warm-up call."""
    call()
    times: list[float] = []
    end = time.perf_counter() + seconds
    while len(times) < MIN_RUNS or time.perf_counter() < end:
        began = time.perf_counter()
        call()
        times.append(time.perf_counter() - began)
    return median(times)


def _time_parts(
    plan: Plan, picture: Picture, device: Device, clock: TimerKind, seconds: float
) -> tuple[tuple[float, ...], float, float]:
    """Time passes, upload and download on a separate context."""
    context = open_context(device.index)
    try:
        with driver_errors():
            resources = GpuResources(context)
            runner = TimedRunner(resources, plan, min(device.texture_size, MAX_SIDE), clock)
            passes = _time_passes(runner, picture, seconds)
            upload = _time_upload(resources, plan, picture, seconds / 4)
            return passes, upload, _time_download(resources, plan, seconds / 4)
    finally:
        close_context(context)


def _time_passes(runner: TimedRunner, picture: Picture, seconds: float) -> tuple[float, ...]:
    runner.run(picture, 1)
    began = time.perf_counter()
    runner.run(picture, 1)
    once = time.perf_counter() - began
    return runner.run(picture, round(min(max(seconds / once, MIN_RUNS), MAX_RUNS)))


def _time_upload(resources: GpuResources, plan: Plan, picture: Picture, seconds: float) -> float:
    planes = {name: plane for node in plan.planes for name, plane in plane_arrays(node, picture).items()}

    def send() -> None:
        resources.upload.send(planes)
        resources.context.finish()

    return median_time(send, seconds) if planes else 0.0


def _time_download(resources: GpuResources, plan: Plan, seconds: float) -> float:
    textures = [
        resources.context.texture(target.shape[::-1], target.format.components, dtype=target.format.dtype)
        for target in result_targets(plan)
    ]
    return median_time(lambda: resources.download.begin(textures).arrays(), seconds) if textures else 0.0


def _time_whole(style: Style, picture: Picture, device: Device, form: Form, seconds: float) -> float:
    """Return the mean time from picture to picture, with one in flight."""
    session = GpuSession(device, form)

    def start(number: int) -> Future[InFlightFrame]:
        return session.start(style, FrameRequest(picture, number / FRAME_RATE))

    def fetch(started: Future[InFlightFrame]) -> None:
        session.fetch(started.result()).result()

    try:
        fetch(start(0))
        before, after = start(1), start(2)
        fetch(before)
        count, began = 0, time.perf_counter()
        while count < MIN_RUNS or time.perf_counter() < began + seconds:
            before, after = after, start(count + 3)
            fetch(before)
            count += 1
        elapsed = time.perf_counter() - began
        fetch(after)
        return elapsed / count
    finally:
        session.close()


TimerKind = Literal["timer queries", "wall clock"]
"""The clock for passes: the GPU's, or the program's with waiting before and after each pass."""

Reading = Callable[[], float]
"""Returns a time in seconds; waits for the GPU if necessary."""


class TimedRunner(Runner):
    """Times passes over many runs, without transfers. The caller owns the context."""

    def __init__(self, resources: GpuResources, plan: Plan, max_side: int, clock: TimerKind) -> None:
        super().__init__(resources, plan, max_side)
        self._clock = clock

    def run(self, picture: Picture, runs: int) -> tuple[float, ...]:
        """Return the median time of each pass for a picture, in seconds."""
        self._request = FrameRequest(picture)
        weights = {each.sampled.step: 1.0 for each in self.plan.passes if each.sampled}
        total = dict.fromkeys(self.plan.passes, 0.0)
        for job in self._jobs:
            uploaded = self._resources.upload.send(self._planes_of(job, picture))
            times: dict[Pass, list[Reading]] = {each: [] for each in job.passes}
            for _, each in product(range(runs), job.passes):
                with self._timed(times[each]):
                    self._run_pass(job, each, uploaded, weights)
            for each in job.passes:
                # Read after all runs are queued, so that the GPU never waits for the program.
                total[each] += median(read() for read in times[each])
        return tuple(total.values())

    @contextmanager
    def _timed(self, times: list[Reading]) -> Iterator[None]:
        """Append a reading of the time that the GPU takes for the block."""
        context = self._resources.context
        if self._clock == "timer queries":
            query = context.query(time=True)
            with query:
                yield
            times.append(lambda: query.elapsed / 1e9)
            return
        context.finish()
        began = time.perf_counter()
        yield
        context.finish()
        elapsed = time.perf_counter() - began
        times.append(lambda: elapsed)
