"""Restyles pictures on the CPU."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor, Future, wait

import numpy as np

from vidstyle.block import moment_of
from vidstyle.core.bands import CallingThread, keep_freed_memory, threads_for
from vidstyle.core.closing import Closing
from vidstyle.core.cores import available_cores
from vidstyle.core.film_colors import FilmPalettes
from vidstyle.core.kernels.library import rehearsing
from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.core.sampling import ExponentialSmoother, small_luma
from vidstyle.core.scene_cuts import SceneCutDetector
from vidstyle.cpu.execute import FrameExecutor
from vidstyle.cpu.frame_order import FrameOrder
from vidstyle.cpu.passthrough import completed_future, is_passthrough
from vidstyle.cpu.schedule import Schedule, schedule
from vidstyle.stabilize.stabilizer import Stabilized, Stabilizer, stabilized_layout
from vidstyle.style import Style
from vidstyle.style.lower import lower
from vidstyle.style.nodes import LoweredStyle, Measure, Node, StepKey
from vidstyle.style.resolve import ResolvedStep, film_tables, has_fixed_marks, resolve, structure

MAX_SIDE_BY_SIDE_PIXELS = 1280 * 720
"""Maximum pixels of a picture for restyling two at the same time: their planes need twice the memory."""


class CpuRenderer(Closing):
    """Restyles one picture after another with one style.

    It keeps the state of measured blocks until a scene cut or another size. Close it, or use it as a context
    manager, to end its threads.

    Args:
        threads: number of threads for pictures given to `start`, and for bands of pictures while a thread has
            no picture; in `run` the calling thread takes bands, too. Default: `available_cores`.
        pool: threads to use instead.

    Attributes:
        frames_in_flight: maximum number of started pictures before a result is requested. Small pictures are
            restyled concurrently, so that threads need not wait for each other as with bands of one picture;
            of large pictures, one is restyled while the next is stabilized.
    """

    frames_in_flight = 1

    def __init__(self, style: Style, threads: int | None = None, pool: Executor | None = None) -> None:
        keep_freed_memory()
        self.style = style
        self._pool = pool or threads_for(threads or available_cores(), "vidstyle-cpu")
        self._started: list[Future[Picture]] = []
        self._order = FrameOrder()
        self._cuts = SceneCutDetector()
        self._shape: tuple[int, int] | None = None
        self._prepared: Style | None = None
        self._steps: dict[str, tuple[ResolvedStep, ...]] = {}
        self._lowered: dict[object, tuple[LoweredStyle, Schedule]] = {}
        self._smoothers: dict[StepKey, ExponentialSmoother] = {}
        self._stabilizer: Stabilizer | None = None
        self._film_palettes = FilmPalettes()

    def close(self) -> None:
        """Finish the started pictures, then end the threads."""
        wait(self._started)  # their bands need threads
        self._pool.shutdown()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self.style = style

    def run(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Picture:
        """Restyle a picture; see `Backend.run` for the arguments."""
        target = target or picture.encoding
        if is_passthrough(picture, self.style, target, rgb):
            return picture
        wait(self._started)
        with rehearsing(lambda: self._rehearse(picture, time, target, rgb)):
            return self._begin(picture, time, target, rgb)()

    def start(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Future[Picture]:
        """Stabilize a picture, and restyle it in another thread."""
        target = target or picture.encoding
        if is_passthrough(picture, self.style, target, rgb):
            return completed_future(picture)
        with rehearsing(lambda: self._rehearse(picture, time, target, rgb)):
            finish = self._begin(picture, time, target, rgb)

        def finished() -> Picture:
            with rehearsing(lambda: self._rehearse(picture, time, target, rgb)):
                return finish()

        if self._film_palettes or math.prod(picture.shape) > MAX_SIDE_BY_SIDE_PIXELS:
            wait(self._started)
        pending = self._pool.submit(finished)
        self._started = [*(each for each in self._started if not each.done()), pending]
        return pending

    def measured(self, picture: Picture) -> dict[StepKey, np.ndarray]:
        """Return the percentiles that each measured step measures on a single picture."""
        self.run(picture, None, picture.encoding, rgb=picture.color is not None)
        return {step: each.numbers for step, each in self._smoothers.items() if each.numbers is not None}

    def _rehearse(self, picture: Picture, time: float | None, target: Encoding, rgb: bool) -> None:
        """Restyle this picture and a similar one, in another thread if necessary, without keeping state."""
        with CpuRenderer(self.style, pool=CallingThread()) as renderer:
            for later in (0, 0.01):
                renderer.run(picture, None if time is None else time + later, target, rgb)

    def _begin(
        self, picture: Picture, time: float | None, target: Encoding, rgb: bool
    ) -> Callable[[], Picture]:
        """Detect a cut and stabilize; return a function that restyles."""
        self._prepare(picture)
        is_steady = self._stabilizer is not None and time is not None
        layout = stabilized_layout(picture) if is_steady else PictureLayout.of(picture)
        lowered, tasks = self._plan(layout, target, rgb)
        remembers = bool(self._smoothers or self._stabilizer or self._film_palettes)
        is_cut = remembers and self._cuts.is_cut(small_luma(picture))
        stable = Stabilized(picture)
        if self._stabilizer:
            stable = self._stabilizer.before(picture, time, is_cut, lowered.reads_chroma)

        order = self._order = FrameOrder(self._order)

        def finish() -> Picture:
            with order:
                self._film_palettes.follow(picture, time, is_cut)
                result = self._restyle(stable.picture, time, is_cut, order, lowered, tasks)
                if self._stabilizer is None:
                    return result
                with order.at(self._stabilizer):
                    return self._stabilizer.after(result, stable)

        return finish

    def _prepare(self, picture: Picture) -> None:
        """Resolve the style again after a change of style or size; keep state if only values differ."""
        if picture.shape == self._shape and self.style is self._prepared:
            return
        wait(self._started)
        steps = resolve(self.style, *picture.shape)
        if picture.shape != self._shape or structure(steps) != structure(self._steps):
            self._stabilizer = None
            self._film_palettes = FilmPalettes()
            self._smoothers = {
                (layer, number): ExponentialSmoother()
                for layer, each in steps.items()
                for number, step in enumerate(each)
                if step.block is not None and step.block.kind == "measured"
            }
        if not self.style.steady:
            self._stabilizer = None
        elif self._stabilizer is None:
            self._stabilizer = Stabilizer(self.style.steady, has_fixed_marks(steps), self._pool)
        else:
            self._stabilizer.change_strength(self.style.steady, has_fixed_marks(steps))
        self._film_palettes.use(film_tables(steps))
        self._steps, self._shape, self._prepared = steps, picture.shape, self.style
        self._lowered = {}

    def _plan(self, layout: PictureLayout, target: Encoding, rgb: bool) -> tuple[LoweredStyle, Schedule]:
        if (layout, target, rgb) not in self._lowered:
            assert self._prepared is not None
            lowered = lower(self._prepared, self._steps, layout, target, rgb)
            self._lowered[layout, target, rgb] = lowered, schedule(lowered)
        return self._lowered[layout, target, rgb]

    def _restyle(
        self,
        picture: Picture,
        time: float | None,
        is_cut: bool,
        order: FrameOrder,
        lowered: LoweredStyle,
        tasks: Schedule,
    ) -> Picture:
        def follow(measure: Measure[Node], measured: np.ndarray) -> np.ndarray:
            smoother = self._smoothers[measure.step]
            with order.at(smoother):
                if is_cut:
                    smoother.restart()
                return smoother.follow(measured, time, measure.time_constant)

        return FrameExecutor(self._pool, tasks, picture, follow, moment_of(time)).picture(lowered)
