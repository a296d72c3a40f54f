"""Restyles pictures on the CPU."""

from __future__ import annotations

from concurrent.futures import Future
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from vidstyle.backend import Backend, FrameRequest, completed_future
from vidstyle.block import moment_of
from vidstyle.core.bands import ONE_THREAD, BandWorkers, keep_freed_memory
from vidstyle.core.kernels.library import rehearsing
from vidstyle.core.machine.cores import available_cores
from vidstyle.core.picture import Picture, PictureLayout
from vidstyle.core.scene_cuts import SceneCutDetector, SceneCuts
from vidstyle.cpu.execute import FilmState, FrameExecutor
from vidstyle.cpu.film_style import FilmStyle, PicturePlan
from vidstyle.cpu.frame_memory import frame_bytes, pictures_in_memory
from vidstyle.cpu.frame_order import FrameOrder
from vidstyle.cpu.frame_threads import FrameThreads
from vidstyle.cpu.remote_style import RemoteStyle
from vidstyle.cpu.scheduling.sweeps import Schedule
from vidstyle.stabilize.motion import FramePair
from vidstyle.stabilize.stabilizer import Stabilized, stabilized_layout
from vidstyle.stabilize.still import flatten_still
from vidstyle.style import Style
from vidstyle.style.nodes import Node, PercentileRequest, StepKey

WAITING_FRAMES = 2
"""Pictures that wait for a thread, so that no thread waits for them."""


@dataclass(frozen=True)
class _Frame:
    """A picture whose restyling has begun.

    Attributes:
        is_cut: whether it begins a scene.
        pair: the picture and the previous one, if its motion is wanted.
        order: its place among the pictures.
        plan: how it is restyled.
    """

    request: FrameRequest
    is_cut: bool
    pair: FramePair | None
    order: FrameOrder
    plan: PicturePlan


class CpuRenderer(Backend):
    """Restyles one picture after another with one style.

    It keeps the state of measured blocks until a scene cut or another size. Close it, or use it as a context
    manager, to end its threads.

    Each picture that `begin` gets has a separate thread, without bands, so that threads never wait for each
    other; if memory is short of a picture for each thread, several threads share one, in bands. A picture
    that `restyle` gets has as many threads as are useful for its size.

    On many cores, the threads of a film have a process each that runs the style (`RemoteStyle`); what
    depends on earlier pictures stays here.

    Args:
        threads: number of threads. Default: `available_cores`.
        cuts: scene cuts of the film, or what detects them for several renderers; None: they are detected.

    Attributes:
        frames_in_flight: number of pictures to start before the result of the first is requested: more than
            are restyled at the same time, so that no thread waits for the next picture.
    """

    device_kind = "cpu"

    def __init__(self, style: Style, threads: int | None = None, cuts: SceneCuts | None = None) -> None:
        keep_freed_memory()
        self._threads = FrameThreads(threads or available_cores())
        self._film = FilmStyle(style, self._threads.settle)
        self._fitted: Schedule | None = None
        self._begun = 0
        self._remote = RemoteStyle()
        self._order = FrameOrder()
        self._cuts = cuts or SceneCutDetector()

    @property
    def style(self) -> Style:
        """The style of the next picture."""
        return self._film.style

    @property
    def frames_in_flight(self) -> int:
        return self._threads.side_by_side + WAITING_FRAMES

    def memory(self) -> list[np.ndarray]:
        """Return the memory of earlier pictures; see `Backend.memory`."""
        return self._film.memory()

    def cancel(self) -> None:
        """Stop the started pictures after their current bands; their results raise CancelledError."""
        self._threads.cancelled.set()
        self._remote.kill()

    def close(self) -> None:
        """Finish the started pictures, then end the threads."""
        self._threads.settle()
        self._remote.close()
        self._threads.close()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self._film.style = style

    def restyle(self, request: FrameRequest) -> Picture:
        """Restyle a picture with several threads; see `Backend.restyle`."""
        if request.is_passthrough(self.style):
            return request.picture
        self._threads.settle()
        with self._rehearsing(request):
            return self._finish(self._follow(request), self._threads.workers(1, request.picture))

    def begin(self, request: FrameRequest) -> Future[Picture]:
        """Restyle a picture in other threads."""
        if request.is_passthrough(self.style):
            return completed_future(request.picture)
        with self._rehearsing(request):
            frame = self._follow(request)
        self._use_memory(frame)
        self._begun += 1
        if self._begun > self.frames_in_flight:  # the first one is finished, so all kernels are stored
            self._start_processes(frame)
        workers = self._threads.workers(self._threads.side_by_side, request.picture)
        return self._threads.submit(partial(self._finish_begun, frame, workers))

    def _finish_begun(self, frame: _Frame, workers: BandWorkers) -> Picture:
        with self._rehearsing(frame.request):
            return self._finish(frame, workers)

    def _use_memory(self, frame: _Frame) -> None:
        """Choose how many pictures like this one are restyled at the same time."""
        tasks, request = frame.plan.tasks, frame.request
        if tasks is self._fitted:
            return
        self._fitted, pictures = tasks, 1
        if not self._film.palettes:
            shape, target = request.picture.shape, request.encoding
            is_steady = self._film.stabilizer is not None and request.time is not None
            pictures = pictures_in_memory(tasks, shape, target, is_steady, self._threads.count)
        self._threads.share(pictures)

    def _start_processes(self, frame: _Frame) -> None:
        """Start processes once, if many pictures are restyled at the same time."""
        (_, tasks, job), count, request = frame.plan, self._threads.side_by_side, frame.request
        shape, target = request.picture.shape, request.encoding
        picture = partial(frame_bytes, tasks, shape, target, False, ONE_THREAD)
        self._remote.start_once(job, count, picture, request.edit)

    def measured(self, picture: Picture) -> dict[StepKey, np.ndarray]:
        """Return the percentiles that each measured step measures on a single picture."""
        self.restyle(FrameRequest(picture, rgb=picture.color is not None))
        return {step: each.numbers for step, each in self._film.smoothers.items() if each.numbers is not None}

    def _rehearsing(self, request: FrameRequest) -> AbstractContextManager[None]:
        return rehearsing(self, lambda: self._rehearse(request))

    def _rehearse(self, request: FrameRequest) -> None:
        """Restyle this picture and a similar one, in another thread if necessary, without keeping state."""
        with CpuRenderer(self._film.style, threads=1) as renderer:
            for later in (0, 0.01):
                time = None if request.time is None else request.time + later
                renderer.restyle(replace(request, time=time, measured=None, tones=None))

    def _follow(self, request: FrameRequest) -> _Frame:
        """Detect a cut, and keep what the next picture needs of this one."""
        request = flatten_still(request, self._film.style.steady)
        picture, time = request.picture, request.time
        self._film.prepare(picture)
        stabilizer, pair = self._film.stabilizer, None
        is_steady = stabilizer is not None and time is not None
        layout = stabilized_layout(picture) if is_steady else PictureLayout.of(picture)
        plan = self._film.plan(layout, request.encoding, request.rgb)
        is_cut = self._film.remembers and self._cuts.begins_scene(picture, time)
        if stabilizer is not None and time is not None:
            pair = stabilizer.follow(picture, time, is_cut)
        self._order = FrameOrder(self._order)
        return _Frame(request, is_cut, pair, self._order, plan)

    def _finish(self, frame: _Frame, workers: BandWorkers) -> Picture:
        with frame.request.measuring():
            request = frame.request.edited(self._remote.make)
            return self._stabilize(replace(frame, request=request), workers)

    def _stabilize(self, frame: _Frame, workers: BandWorkers) -> Picture:
        """Stabilize and restyle."""
        order, stabilizer = frame.order, self._film.stabilizer
        picture, time = frame.request.picture, frame.request.time
        with order:
            self._film.palettes.follow(picture, time, frame.is_cut)
            if stabilizer is None:
                return self._restyle(frame, picture, workers)
            stable, drift = Stabilized(picture), None
            if time is not None:
                warp = frame.pair.warp() if frame.pair else None
                with order.at(stabilizer.source):
                    stable = stabilizer.before(picture, warp, workers, frame.plan.lowered.reads_chroma)
                if marks := stabilizer.marks:
                    with order.at(marks):
                        drift = marks.follow(picture, warp)
            result = self._restyle(frame, stable.picture, workers, drift)
            with order.at(stabilizer.result):
                return stabilizer.after(result, stable, workers)

    def _restyle(
        self, frame: _Frame, picture: Picture, workers: BandWorkers, drift: np.ndarray | None = None
    ) -> Picture:
        plan, time = frame.plan, frame.request.time
        shown = FilmState(moment_of(time), drift)

        def follow(step: StepKey, time_constant: float, measured: np.ndarray) -> np.ndarray:
            smoother = self._film.smoothers[step]
            with frame.order.at(smoother):
                if frame.is_cut:
                    smoother.restart()
                own = smoother.follow(measured, time, time_constant)
            return frame.request.tones_of(step, lambda: own)

        result, follow_here = self._remote.restyle(plan.job, picture, shown, follow)
        if result is not None:
            return result

        def smoothed(measure: PercentileRequest[Node], measured: np.ndarray) -> np.ndarray:
            return follow_here(measure.step, measure.time_constant, measured)

        return FrameExecutor(workers, plan.tasks, picture, smoothed, shown).picture(plan.lowered)
