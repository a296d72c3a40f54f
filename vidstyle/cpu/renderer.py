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
from vidstyle.cpu.plain import done, stays
from vidstyle.cpu.schedule import Schedule, schedule
from vidstyle.cpu.turn import Turn
from vidstyle.stabilize.stabilizer import Stabilized, Stabilizer, stabilized_layout
from vidstyle.style import Style
from vidstyle.style.lower import lower
from vidstyle.style.nodes import LoweredStyle, Measure, Node, StepKey
from vidstyle.style.resolve import ResolvedStep, film_tables, has_fixed_marks, resolve, structure

SIDE_BY_SIDE = 1280 * 720
"""Pixels of a picture up to which two are restyled at the same time: their planes take twice the memory."""


class CpuRenderer(Closing):
    """Restyles one picture after another with one style.

    It keeps what measured blocks remember of earlier pictures, until a scene cut or another size.
    Close it, or use it as a context manager, to end its threads.

    Args:
        threads: for pictures that `start` takes, and for bands of pictures while a thread has none of its
            own; in `run` the calling one takes bands too. Default: `available_cores`.
        pool: threads, instead.

    Attributes:
        frames_in_flight: how many pictures may be under way before a result is asked for. Small ones are
            restyled side by side, so that threads need not wait for each other as for bands of one picture;
            of large ones, one is restyled while the next one is stabilized.
    """

    frames_in_flight = 1

    def __init__(self, style: Style, threads: int | None = None, pool: Executor | None = None) -> None:
        keep_freed_memory()
        self.style = style
        self._pool = pool or threads_for(threads or available_cores(), "vidstyle-cpu")
        self._started: list[Future[Picture]] = []
        self._turn = Turn()
        self._cuts = SceneCutDetector()
        self._shape: tuple[int, int] | None = None
        self._prepared: Style | None = None
        self._steps: dict[str, tuple[ResolvedStep, ...]] = {}
        self._lowered: dict[object, tuple[LoweredStyle, Schedule]] = {}
        self._smoothers: dict[StepKey, ExponentialSmoother] = {}
        self._stabilizer: Stabilizer | None = None
        self._film_palettes = FilmPalettes()

    def close(self) -> None:
        """End the threads, after the pictures that have been started."""
        wait(self._started)  # their bands need threads
        self._pool.shutdown()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self.style = style

    def run(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Picture:
        """Restyle a picture; the arguments are those of `Backend.run`."""
        target = target or picture.encoding
        if stays(picture, self.style, target, rgb):
            return picture
        wait(self._started)
        with rehearsing(lambda: self._rehearse(picture, time, target, rgb)):
            return self._begin(picture, time, target, rgb)()

    def start(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Future[Picture]:
        """Stabilize a picture, and restyle it in another thread."""
        target = target or picture.encoding
        if stays(picture, self.style, target, rgb):
            return done(picture)
        with rehearsing(lambda: self._rehearse(picture, time, target, rgb)):
            finish = self._begin(picture, time, target, rgb)

        def finished() -> Picture:
            with rehearsing(lambda: self._rehearse(picture, time, target, rgb)):
                return finish()

        if self._film_palettes or math.prod(picture.shape) > SIDE_BY_SIDE:
            wait(self._started)
        pending = self._pool.submit(finished)
        self._started = [*(each for each in self._started if not each.done()), pending]
        return pending

    def measured(self, picture: Picture) -> dict[StepKey, np.ndarray]:
        """The percentiles that each measured step takes of a picture that stands alone."""
        self.run(picture, None, picture.encoding, rgb=picture.color is not None)
        return {step: each.numbers for step, each in self._smoothers.items() if each.numbers is not None}

    def _rehearse(self, picture: Picture, time: float | None, target: Encoding, rgb: bool) -> None:
        """Restyle this picture and one like it, in another thread if need be, and remember nothing."""
        with CpuRenderer(self.style, pool=CallingThread()) as renderer:
            for later in (0, 0.01):
                renderer.run(picture, None if time is None else time + later, target, rgb)

    def _begin(
        self, picture: Picture, time: float | None, target: Encoding, rgb: bool
    ) -> Callable[[], Picture]:
        """Detect a cut and stabilize; what is returned restyles."""
        self._prepare(picture)
        is_steady = self._stabilizer is not None and time is not None
        layout = stabilized_layout(picture) if is_steady else PictureLayout.of(picture)
        lowered, tasks = self._planned(layout, target, rgb)
        remembers = bool(self._smoothers or self._stabilizer or self._film_palettes)
        is_cut = remembers and self._cuts.is_cut(small_luma(picture))
        stable = Stabilized(picture)
        if self._stabilizer:
            stable = self._stabilizer.before(picture, time, is_cut, lowered.reads_chroma)

        turn = self._turn = Turn(self._turn)

        def finish() -> Picture:
            with turn:
                self._film_palettes.follow(picture, time, is_cut)
                result = self._styled(stable.picture, time, is_cut, turn, lowered, tasks)
                if self._stabilizer is None:
                    return result
                with turn.at(self._stabilizer):
                    return self._stabilizer.after(result, stable)

        return finish

    def _prepare(self, picture: Picture) -> None:
        """Resolve the style anew for another style or size; memory goes on where only values differ."""
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

    def _planned(self, layout: PictureLayout, target: Encoding, rgb: bool) -> tuple[LoweredStyle, Schedule]:
        if (layout, target, rgb) not in self._lowered:
            assert self._prepared is not None
            lowered = lower(self._prepared, self._steps, layout, target, rgb)
            self._lowered[layout, target, rgb] = lowered, schedule(lowered)
        return self._lowered[layout, target, rgb]

    def _styled(
        self,
        picture: Picture,
        time: float | None,
        is_cut: bool,
        turn: Turn,
        lowered: LoweredStyle,
        tasks: Schedule,
    ) -> Picture:
        def follow(measure: Measure[Node], measured: np.ndarray) -> np.ndarray:
            smoother = self._smoothers[measure.step]
            with turn.at(smoother):
                if is_cut:
                    smoother.restart()
                return smoother.follow(measured, time, measure.time_constant)

        return FrameExecutor(self._pool, tasks, picture, follow, moment_of(time)).picture(lowered)
