"""A style while pictures of a film are restyled on the CPU: its plans, and what it remembers."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from vidstyle.core.color.film_colors import FilmPalettes
from vidstyle.core.picture import Encoding, Picture, PictureLayout
from vidstyle.core.sampling import ExponentialSmoother
from vidstyle.cpu.scheduling.schedule import schedule
from vidstyle.cpu.scheduling.sweeps import Schedule
from vidstyle.cpu.style_job import StyleJob
from vidstyle.stabilize.stabilizer import Stabilizer
from vidstyle.style import Style
from vidstyle.style.lower import lower
from vidstyle.style.nodes import LoweredStyle, StepKey
from vidstyle.style.resolve import (
    ResolvedStep,
    film_tables,
    has_fixed_marks,
    has_moving_marks,
    measurement_key,
    resolve,
)


class PicturePlan(NamedTuple):
    """How pictures of a layout are restyled.

    Attributes:
        lowered: the style for them.
        tasks: how it is computed.
        job: the style for other processes; None if they cannot restyle the pictures.
    """

    lowered: LoweredStyle
    tasks: Schedule
    job: bytes | None


class FilmStyle:
    """A style, resolved for the size of the present picture, and its memory of earlier pictures.

    It keeps the memory until another size or other steps follow.

    Args:
        style: the style.
        settle: waits until no picture uses the memory; called before it is replaced.

    Attributes:
        style: set another one to use it from the next `prepare` on.
        smoothers: of the numbers that its steps measure.
        stabilizer: None if the style needs none.
        palettes: its colours of a film.
    """

    def __init__(self, style: Style, settle: Callable[[], object]) -> None:
        self.style, self._settle = style, settle
        self.smoothers: dict[StepKey, ExponentialSmoother] = {}
        self.stabilizer: Stabilizer | None = None
        self.palettes = FilmPalettes()
        self._shape: tuple[int, int] | None = None
        self._prepared: Style | None = None
        self._steps: dict[str, tuple[ResolvedStep, ...]] = {}
        self._plans: dict[object, PicturePlan] = {}

    @property
    def remembers(self) -> bool:
        """Whether a picture depends on earlier ones."""
        return bool(self.smoothers or self.stabilizer or self.palettes)

    def memory(self) -> list[np.ndarray]:
        """Return the memory of earlier pictures; see `Backend.memory`."""
        numbers = [each.numbers for each in self.smoothers.values() if each.numbers is not None]
        return numbers + (self.stabilizer.memory() if self.stabilizer else [])

    def prepare(self, picture: Picture) -> None:
        """Resolve the style again after a change of style or size; keep memory if only values differ."""
        if picture.shape == self._shape and self.style is self._prepared:
            return
        steps = resolve(self.style, *picture.shape)
        same_steps = measurement_key(steps) == measurement_key(self._steps)
        has_other_structure = picture.shape != self._shape or not same_steps
        has_stabilizer = self.stabilizer is not None
        if has_other_structure or (self.style.steady > 0) != has_stabilizer or film_tables(self._steps):
            self._settle()
        if has_other_structure:
            self._forget(steps)
        self._use_stabilizer(has_fixed_marks(steps), has_moving_marks(steps))
        self.palettes.use(film_tables(steps))
        self._steps, self._shape, self._prepared = steps, picture.shape, self.style
        self._plans = {}

    def _forget(self, steps: dict[str, tuple[ResolvedStep, ...]]) -> None:
        self.stabilizer = None
        self.palettes = FilmPalettes()
        self.smoothers = {
            (layer, number): ExponentialSmoother()
            for layer, each in steps.items()
            for number, step in enumerate(each)
            if step.settle is not None
        }

    def _use_stabilizer(self, is_fixed: bool, has_moving: bool) -> None:
        if not self.style.steady > 0:
            self.stabilizer = None
        elif self.stabilizer is None:
            self.stabilizer = Stabilizer(self.style.steady, is_fixed, has_moving)
        else:
            self.stabilizer.change_strength(self.style.steady, is_fixed)

    def plan(self, layout: PictureLayout, target: Encoding, rgb: bool) -> PicturePlan:
        """Return the plan of the prepared style for pictures of a layout and their results."""
        if (layout, target, rgb) not in self._plans:
            assert self._prepared is not None
            lowered = lower(self._prepared, self._steps, layout, target, rgb)
            tasks, job = schedule(lowered), StyleJob(self._prepared, layout, target, rgb)
            stays_here = tasks.has_network or bool(film_tables(self._steps))
            self._plans[layout, target, rgb] = PicturePlan(
                lowered, tasks, None if stays_here else job.packed()
            )
        return self._plans[layout, target, rgb]
