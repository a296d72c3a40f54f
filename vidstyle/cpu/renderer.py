"""Restyles pictures on the CPU."""

from __future__ import annotations

import threading
from concurrent.futures import Future, ThreadPoolExecutor, wait
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.backend import Backend, FrameRequest, completed_future
from vidstyle.block import moment_of
from vidstyle.core.bands import (
    MAX_SMALL_BAND_THREADS,
    ONE_THREAD,
    BandWorkers,
    keep_freed_memory,
    threads_for,
    useful_threads,
)
from vidstyle.core.color.film_colors import FilmPalettes
from vidstyle.core.kernels.library import rehearsing
from vidstyle.core.machine.cores import available_cores, single_threaded_opencv
from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.core.sampling import ExponentialSmoother
from vidstyle.core.scene_cuts import SceneCutDetector, SceneCuts
from vidstyle.cpu.execute import FilmState, FrameExecutor
from vidstyle.cpu.frame_memory import frame_bytes, pictures_in_memory
from vidstyle.cpu.frame_order import FrameOrder
from vidstyle.cpu.remote_style import RemoteStyle
from vidstyle.cpu.schedule import Schedule, schedule
from vidstyle.cpu.style_job import StyleJob
from vidstyle.stabilize.motion import FramePair
from vidstyle.stabilize.stabilizer import Stabilized, Stabilizer, stabilized_layout
from vidstyle.stabilize.still import flatten_still
from vidstyle.style import Style
from vidstyle.style.lower import lower
from vidstyle.style.nodes import LoweredStyle, Node, PercentileRequest, StepKey
from vidstyle.style.resolve import (
    ResolvedStep,
    film_tables,
    has_fixed_marks,
    has_moving_marks,
    measurement_key,
    resolve,
)

WAITING_FRAMES = 2
"""Pictures that wait for a thread, so that no thread waits for them."""


@dataclass(frozen=True)
class _Frame:
    """A picture whose restyling has begun.

    Attributes:
        is_cut: whether it begins a scene.
        pair: the picture and the previous one, if its motion is wanted.
        order: its place among the pictures.
        job: for other processes; None if they cannot restyle it.
    """

    request: FrameRequest
    is_cut: bool
    pair: FramePair | None
    order: FrameOrder
    lowered: LoweredStyle
    tasks: Schedule
    job: bytes | None


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
        self.style = style
        self._threads = threads or available_cores()
        self._pool = threads_for(self._threads, "vidstyle-cpu")
        self._cancelled = threading.Event()
        self._frame_pool = self._pool
        self._settings = ExitStack()
        self._fitted: Schedule | None = None
        self._side_by_side = self._threads
        self._started: list[Future[Picture]] = []
        self._begun = 0
        self._remote = RemoteStyle()
        self._order = FrameOrder()
        self._cuts = cuts or SceneCutDetector()
        self._shape: tuple[int, int] | None = None
        self._prepared: Style | None = None
        self._steps: dict[str, tuple[ResolvedStep, ...]] = {}
        self._lowered: dict[object, tuple[LoweredStyle, Schedule, bytes | None]] = {}
        self._smoothers: dict[StepKey, ExponentialSmoother] = {}
        self._stabilizer: Stabilizer | None = None
        self._film_palettes = FilmPalettes()

    @property
    def frames_in_flight(self) -> int:
        return self._side_by_side + WAITING_FRAMES

    def memory(self) -> list[np.ndarray]:
        """Return the memory of earlier pictures; see `Backend.memory`."""
        numbers = [each.numbers for each in self._smoothers.values() if each.numbers is not None]
        return numbers + (self._stabilizer.memory() if self._stabilizer else [])

    def cancel(self) -> None:
        """Stop the started pictures after their current bands; their results raise CancelledError."""
        self._cancelled.set()
        self._remote.kill()

    def close(self) -> None:
        """Finish the started pictures, then end the threads."""
        wait(self._started)  # their bands need threads
        self._remote.close()
        self._settings.close()
        self._pool.shutdown()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self.style = style

    def restyle(self, request: FrameRequest) -> Picture:
        """Restyle a picture with several threads; see `Backend.restyle`."""
        if request.is_passthrough(self.style):
            return request.picture
        wait(self._started)
        with self._rehearsing(request):
            return self._finish(self._follow(request), self._workers(1, request.picture))

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
        pending = self._frame_pool.submit(
            self._finish_begun, frame, self._workers(self._side_by_side, request.picture)
        )
        self._started = [*(each for each in self._started if not each.done()), pending]
        return pending

    def _finish_begun(self, frame: _Frame, workers: BandWorkers) -> Picture:
        with self._rehearsing(frame.request):
            return self._finish(frame, workers)

    def _use_memory(self, frame: _Frame) -> None:
        """Choose how many pictures like this one are restyled at the same time."""
        if frame.tasks is self._fitted:
            return
        self._fitted, self._side_by_side = frame.tasks, 1
        if not self._film_palettes:
            request = frame.request
            shape, target = request.picture.shape, request.encoding
            is_steady = self._stabilizer is not None and request.time is not None
            self._side_by_side = pictures_in_memory(frame.tasks, shape, target, is_steady, self._threads)
        self._settings.close()
        self._frame_pool = self._pool
        if self._side_by_side < self._threads:
            # A separate pool of few threads, as the C library keeps the memory of a frame for each thread.
            self._frame_pool = ThreadPoolExecutor(self._side_by_side, "vidstyle-frame")
            self._settings.enter_context(self._frame_pool)
        if self._side_by_side > 1:
            self._settings.enter_context(single_threaded_opencv())

    def _start_processes(self, frame: _Frame) -> None:
        """Start processes once, if many pictures are restyled at the same time."""
        if self._remote.may_start(frame.job, self._side_by_side):
            request = frame.request
            picture = frame_bytes(frame.tasks, request.picture.shape, request.encoding, False, ONE_THREAD)
            self._remote.start(frame.job, self._side_by_side, picture)

    def _workers(self, frames: int, picture: Picture) -> BandWorkers:
        """Return the threads of a picture, one of `frames` that are restyled at the same time."""
        threads = useful_threads(picture.shape, -(-self._threads // frames))
        seldom_waits = self._threads <= MAX_SMALL_BAND_THREADS
        return BandWorkers(self._pool, threads, self._cancelled, seldom_waits)

    def measured(self, picture: Picture) -> dict[StepKey, np.ndarray]:
        """Return the percentiles that each measured step measures on a single picture."""
        self.restyle(FrameRequest(picture, rgb=picture.color is not None))
        return {step: each.numbers for step, each in self._smoothers.items() if each.numbers is not None}

    def _rehearsing(self, request: FrameRequest) -> AbstractContextManager[None]:
        return rehearsing(self, lambda: self._rehearse(request))

    def _rehearse(self, request: FrameRequest) -> None:
        """Restyle this picture and a similar one, in another thread if necessary, without keeping state."""
        with CpuRenderer(self.style, threads=1) as renderer:
            for later in (0, 0.01):
                time = None if request.time is None else request.time + later
                renderer.restyle(replace(request, time=time, measured=None, tones=None))

    def _follow(self, request: FrameRequest) -> _Frame:
        """Detect a cut, and keep what the next picture needs of this one."""
        request = flatten_still(request, self.style.steady)
        picture, time = request.picture, request.time
        self._prepare(picture)
        stabilizer, pair = self._stabilizer, None
        is_steady = stabilizer is not None and time is not None
        layout = stabilized_layout(picture) if is_steady else PictureLayout.of(picture)
        plan = self._plan(layout, request.encoding, request.rgb)
        remembers = bool(self._smoothers or stabilizer or self._film_palettes)
        is_cut = remembers and self._cuts.begins_scene(picture, time)
        if stabilizer is not None and time is not None:
            pair = stabilizer.follow(picture, time, is_cut)
        self._order = FrameOrder(self._order)
        return _Frame(request, is_cut, pair, self._order, *plan)

    def _finish(self, frame: _Frame, workers: BandWorkers) -> Picture:
        with frame.request.measuring():
            return self._stabilize(replace(frame, request=frame.request.edited()), workers)

    def _stabilize(self, frame: _Frame, workers: BandWorkers) -> Picture:
        """Stabilize and restyle."""
        order, stabilizer = frame.order, self._stabilizer
        picture, time = frame.request.picture, frame.request.time
        with order:
            self._film_palettes.follow(picture, time, frame.is_cut)
            if stabilizer is None:
                return self._restyle(frame, picture, workers)
            stable = Stabilized(picture)
            if time is not None:
                warp = frame.pair.warp() if frame.pair else None
                with order.at(stabilizer.source):
                    stable = stabilizer.before(picture, warp, workers, frame.lowered.reads_chroma)
            result = self._restyle(frame, stable.picture, workers, stable.drift)
            with order.at(stabilizer.result):
                return stabilizer.after(result, stable, workers)

    def _prepare(self, picture: Picture) -> None:
        """Resolve the style again after a change of style or size; keep state if only values differ."""
        if picture.shape == self._shape and self.style is self._prepared:
            return
        steps = resolve(self.style, *picture.shape)
        same_steps = measurement_key(steps) == measurement_key(self._steps)
        has_other_structure = picture.shape != self._shape or not same_steps
        needs_stabilizer = self.style.steady > 0
        if has_other_structure or needs_stabilizer != bool(self._stabilizer) or film_tables(self._steps):
            wait(self._started)  # they use what changes here
        if has_other_structure:
            self._stabilizer = None
            self._film_palettes = FilmPalettes()
            self._smoothers = {
                (layer, number): ExponentialSmoother()
                for layer, each in steps.items()
                for number, step in enumerate(each)
                if step.settle is not None
            }
        if not needs_stabilizer:
            self._stabilizer = None
        elif self._stabilizer is None:
            marks = has_fixed_marks(steps), has_moving_marks(steps)
            self._stabilizer = Stabilizer(self.style.steady, *marks)
        else:
            self._stabilizer.change_strength(self.style.steady, has_fixed_marks(steps))
        self._film_palettes.use(film_tables(steps))
        self._steps, self._shape, self._prepared = steps, picture.shape, self.style
        self._lowered = {}

    def _plan(
        self, layout: PictureLayout, target: Encoding, rgb: bool
    ) -> tuple[LoweredStyle, Schedule, bytes | None]:
        if (layout, target, rgb) not in self._lowered:
            assert self._prepared is not None
            lowered = lower(self._prepared, self._steps, layout, target, rgb)
            tasks, job = schedule(lowered), StyleJob(self._prepared, layout, target, rgb)
            stays_here = tasks.has_network or bool(film_tables(self._steps))
            self._lowered[layout, target, rgb] = lowered, tasks, None if stays_here else job.packed()
        return self._lowered[layout, target, rgb]

    def _restyle(
        self, frame: _Frame, picture: Picture, workers: BandWorkers, drift: np.ndarray | None = None
    ) -> Picture:
        time = frame.request.time
        shown = FilmState(moment_of(time), drift)

        def follow(step: StepKey, time_constant: float, measured: np.ndarray) -> np.ndarray:
            smoother = self._smoothers[step]
            with frame.order.at(smoother):
                if frame.is_cut:
                    smoother.restart()
                own = smoother.follow(measured, time, time_constant)
            return frame.request.tones_of(step, lambda: own)

        result, follow_here = self._remote.restyle(frame.job, picture, shown, follow)
        if result is not None:
            return result

        def smoothed(measure: PercentileRequest[Node], measured: np.ndarray) -> np.ndarray:
            return follow_here(measure.step, measure.time_constant, measured)

        return FrameExecutor(workers, frame.tasks, picture, smoothed, shown).picture(frame.lowered)
