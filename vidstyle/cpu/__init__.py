"""Runs a style with NumPy, OpenCV and Numba: the definition of what is right."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from vidstyle.blade.inference import BankRun
from vidstyle.core.bands import CORES
from vidstyle.core.measured import ExponentialSmoother, small_luma
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.resample import resample
from vidstyle.core.scene_cuts import SceneCutDetector
from vidstyle.cpu.band import Band, Whole
from vidstyle.cpu.output import Page, at_size, finish
from vidstyle.cpu.work import Call, Work, run_bank
from vidstyle.stabilize.stabilizer import Stabilizer
from vidstyle.style import SOURCE, Style
from vidstyle.style.resolve import ResolvedStep, has_fixed_marks, resolve, structure


class CpuRenderer:
    """Restyles one picture after another with one style.

    It keeps what measured blocks remember of earlier pictures; a cut or another size starts it afresh.
    Close it, or use it as a context manager, to let its threads go.

    Attributes:
        frames_in_flight: how many pictures may be under way before a result is asked for.
    """

    frames_in_flight = 0

    def __init__(self, style: Style, threads: int = CORES) -> None:
        self.style = style
        self._pool = ThreadPoolExecutor(threads, thread_name_prefix="vidstyle-cpu")
        self._shape: tuple[int, int] | None = None
        self._prepared: Style | None = None
        self._layers: dict[str, tuple[ResolvedStep, ...]] = {}
        self._memories: dict[tuple[str, int], ExponentialSmoother] = {}
        self._cuts = SceneCutDetector()
        self._steady: Stabilizer | None = None

    def __enter__(self) -> CpuRenderer:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Let the threads go."""
        self._pool.shutdown()

    def change_style(self, style: Style) -> None:
        """Use another style from the next picture on."""
        self.style = style

    def run(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Picture:
        """The picture in the style, at its own size.

        Args:
            picture: any picture; its planes are only read.
            time: presentation time in seconds, or None for a picture that stands alone.
            target: how the planes of the result are to be encoded; None: as the picture's own.
            rgb: packed RGB of the target's depth is wanted instead of luma and chroma.
        """
        target = target or picture.encoding
        if self.style.is_plain and target == picture.encoding and rgb == (picture.color is not None):
            return picture
        self._prepare(picture)
        begins = bool(self._memories or self._steady) and self._cuts.is_cut(small_luma(picture))
        if begins:
            for memory in self._memories.values():
                memory.restart()
        if self._steady is None:
            return self._styled(picture, time, target, rgb)
        steadied = self._steady.before(picture, time, begins)
        return self._steady.after(self._styled(steadied.picture, time, target, rgb), steadied)

    def start(
        self, picture: Picture, time: float | None = None, target: Encoding | None = None, rgb: bool = False
    ) -> Future[Picture]:
        """As `run`, for callers that also use a GPU, whose results come later."""
        future: Future[Picture] = Future()
        future.set_result(self.run(picture, time, target, rgb))
        return future

    def _styled(self, picture: Picture, time: float | None, target: Encoding, rgb: bool) -> Picture:
        return finish(self._pool, self._page(picture, time), picture, target, rgb)

    def _prepare(self, picture: Picture) -> None:
        """Resolve the style anew for another style or size; memory goes on where only values differ."""
        if picture.shape == self._shape and self.style is self._prepared:
            return
        layers = resolve(self.style, *picture.shape)
        if picture.shape != self._shape or structure(layers) != structure(self._layers):
            self._steady = None
            self._memories = {
                (layer, number): ExponentialSmoother()
                for layer, steps in layers.items()
                for number, step in enumerate(steps)
                if step.block is not None and step.block.kind == "measured"
            }
        if not self.style.steady:
            self._steady = None
        elif self._steady is None:
            self._steady = Stabilizer(self.style.steady, has_fixed_marks(layers), self._pool)
        else:
            self._steady.change_strength(self.style.steady, has_fixed_marks(layers))
        self._layers, self._shape, self._prepared = layers, picture.shape, self.style

    def _page(self, picture: Picture, time: float | None) -> Page:
        """base, then background and lines from where it ended."""
        frame = _FrameRun(self._pool, picture, time, self._memories)
        base = frame.run_layer("base", self._layers["base"], Work(Whole.of(picture)))
        steps = self._layers["background"], self._layers["lines"]
        if steps[0] and steps[1]:
            base = base.finished(self._pool)  # once for both
        background = lines = None
        if steps[0] or not steps[1]:
            background = frame.run_layer("background", steps[0], base)
        if steps[1]:
            lines = frame.run_layer("lines", steps[1], base)
        shape = picture.shape
        fitted = (None if work is None else frame.fit(work, shape) for work in (background, lines))
        return Page.of(self.style, *fitted)


class _FrameRun:
    """One picture's way through the layers, with the pictures saved on it."""

    def __init__(
        self,
        pool: ThreadPoolExecutor,
        source: Picture,
        time: float | None,
        memories: dict[tuple[str, int], ExponentialSmoother],
    ) -> None:
        self._pool, self._time, self._memories = pool, time, memories
        self._saved: dict[str, Work] = {SOURCE: Work(Whole.of(source))}

    def run_layer(self, layer: str, steps: tuple[ResolvedStep, ...], work: Work) -> Work:
        """The work after all steps of a layer."""
        for number, step in enumerate(steps):
            work = self._saved[step.source] if step.source else work
            if step.block is not None:
                work = self._run_step(step, work, self._memories.get((layer, number)))
            if step.save:
                work = self._saved[step.save] = work.finished(self._pool)
        return work

    def fit(self, work: Work, shape: tuple[int, int]) -> Work:
        """The work back at the page's own size."""
        return work if work.shape == shape else Work(at_size(work.done(self._pool), shape, work.back))

    def _run_step(self, step: ResolvedStep, work: Work, memory: ExponentialSmoother | None) -> Work:
        block = step.block
        assert block is not None
        if block.saves:
            work = self._saved[block.saves] = work.finished(self._pool)
        if block.kind == "resize":
            return self._resize(step, work)
        if block.kind == "learned" and (run := block.function(**step.values)).scale != 1:
            return self._run_smaller(run, work)
        if (block.reads_neighbors or memory is not None) and work.calls:
            work = work.finished(self._pool)
        numbers = None
        if memory is not None:
            measure = np.percentile(small_luma(work.whole.main), block.percentiles_for(step.values))
            numbers = memory.follow(measure, self._time, step.values.get("settle", 0))
        pictures = {name: self._saved_at(saved, work.shape) for name, saved in step.pictures.items()}
        return work.then(Call(step, numbers, pictures, work.shape))

    def _saved_at(self, name: str, shape: tuple[int, int]) -> Whole:
        return at_size(self._saved[name].whole, shape, "bilinear")

    def _run_smaller(self, run: BankRun, work: Work) -> Work:
        """A bank on the luma of a reduced picture; the chroma stays as it is."""
        whole = work.done(self._pool)
        luma = Band(whole, 0, work.shape[0]).luma()
        reduced = resample(luma, run.shape_at_scale(work.shape), "area")
        luma = resample(run_bank(self._pool, run, reduced), work.shape, "bicubic")
        encoding = whole.main.encoding.as_float()
        return replace(work, whole=Whole(Picture(encoding, luma=luma), whole.tint), calls=())

    def _resize(self, step: ResolvedStep, work: Work) -> Work:
        assert step.block is not None
        size = step.block.function(work.shape, **step.values)
        resized = at_size(work.done(self._pool), size, step.values["method"])
        return Work(resized, back=step.values["back"])
