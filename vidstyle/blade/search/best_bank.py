"""Trains the best of several layouts of a bank, in one or two stages."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.before.luma_steps import luma_steps, prepare
from vidstyle.blade.photographs import Photograph, chroma_of, luma_of
from vidstyle.blade.reference_filter import ReferenceFilter
from vidstyle.blade.regression import TrainingConfig, solve_weights
from vidstyle.blade.search.color_matrix import find_color_matrix, square_of
from vidstyle.blade.search.form_bank import bank_of
from vidstyle.blade.search.luma_step import find_luma_step
from vidstyle.blade.search.second_stage import KeptPlanes, train_second_stage
from vidstyle.blade.search.stored_results import stored_results
from vidstyle.blade.search.trial import Trial, best_form
from vidstyle.blade.training import OnPicture, TrainingReport, description, report
from vidstyle.core.color.deferred_color import Mixed
from vidstyle.core.machine.cores import available_cores

MAX_SEARCH_SIZE_PX = 7
"""Size of filters above which only the layouts that are best at this size are trained."""
MATRIX_PICTURES = 6
"""Maximum number of pictures from which a colour matrix is found; they are in memory at the same time."""
MIN_REST = 0.05
"""The part of the change that a bank must leave so that a second stage and a step before it are tried."""
MIN_STEP_GAIN = 0.2
"""The part of this rest that a step before the filters must remove: a local mode takes longer than a bank."""


@dataclass(frozen=True)
class _Trained:
    """A bank, its training, and the share of the change that it leaves in cross-validation."""

    bank: Bank
    report: TrainingReport
    rest: float


def train_best(
    configs: Sequence[TrainingConfig],
    reference: ReferenceFilter,
    photographs: Sequence[Photograph],
    on_picture: OnPicture = lambda *_: None,
    chroma: bool = False,
    stages: int = 1,
) -> tuple[Bank, TrainingReport]:
    """Train a bank of the layout that explains most of the change; with `chroma` also for the chroma planes.

    Each layout is trained on two thirds of the pictures and checked on the others, in turn, with filters that
    keep flat areas flat and with affine ones. The best is then trained on all pictures. A second stage is
    trained in the same way on the results of the first one for pictures from which it has not learned. If
    the filter mixes colours, a colour matrix comes first. If a tone curve through percentiles or a local mode
    alone comes nearer to the filter, a bank after it is trained, too, and kept if it is clearly better.
    Layouts of large filters are compared with smaller ones: the time of training grows with the square of
    their area. The filter runs once on each picture.

    Args:
        configs: the layouts, simpler ones first; a later one must be better by `MIN_LAYOUT_GAIN`.
        stages: maximum number of stages, 1 or 2; banks of several parts have one. With 1, there is no local
            mode, either.

    Raises:
        InputError: a picture cannot be read, or the reference filter fails.
        UsageError: the reference filter's settings are invalid.
    """
    is_single = len(reference.parts) == 1
    with stored_results(reference) as stored:
        search = _Search(stored, photographs, on_picture, chroma, stages if is_single else 1)
        if len(configs) == 1 or configs[0].size <= MAX_SEARCH_SIZE_PX:
            found = search.best(configs)
        else:
            small = search.best([replace(each, size=MAX_SEARCH_SIZE_PX) for each in configs]).bank
            layouts = [(each.bins, each.clips) for each in small.stages]
            configs = [each for each in configs if (each.bins, each.clips) in layouts]
            names = [name for name in ("curve", "mode") if getattr(small, name) is not None]
            found = search.train(configs, {name: getattr(small, name) for name in names})
    return found.bank, found.report


@dataclass(frozen=True)
class _Search:
    """The search for a bank that comes near to a filter; see `train_best`."""

    reference: ReferenceFilter
    photographs: Sequence[Photograph]
    on_picture: OnPicture
    chroma: bool
    stages: int

    def best(self, configs: Sequence[TrainingConfig]) -> _Trained:
        """Return the best bank, perhaps with a step before its filters."""
        plain = self.train(configs, {})
        if len(self.reference.parts) > 1 or plain.rest <= MIN_REST:
            return plain
        step, rest = find_luma_step(list(self._some_planes()), with_modes=self.stages > 1)
        if rest > plain.rest:
            return plain  # a bank after it would cost much and gain little
        other = self.train(configs, step)
        return other if other.rest < (1 - MIN_STEP_GAIN) * plain.rest else plain

    def train(self, configs: Sequence[TrainingConfig], step: Mapping[str, np.ndarray]) -> _Trained:
        """Train the best layout after a step, which is a `curve` or `mode` of a bank, or none."""
        trials, clipped = [Trial(config, self.chroma) for config in configs], []
        matrix = (
            None if step else self._matrix
        )  # found with the step's effect, such as the mean of many curves
        steps = luma_steps(step.get("curve"), step.get("mode"))
        changes, count = np.zeros(2), len(self.photographs)
        with ThreadPoolExecutor(available_cores()) as pool, TemporaryDirectory() as folder:
            kept = KeptPlanes(Path(folder), configs[0].scale)
            for number, photograph in enumerate(self.photographs, 1):
                color, targets = self._filtered(photograph)
                clipped.append(_ends_share(targets[0]) - _ends_share(color))
                changes[0] += square_of(targets[0], luma_of(color), self._chroma_of(color))
                color = color if matrix is None else Mixed(color, matrix).whole()
                luma, planes = prepare(luma_of(color), steps), self._chroma_of(color)
                changes[1] += square_of(targets[0], luma, planes)
                for trial in trials:
                    trial.add(number, luma, planes, targets, pool)
                if self.stages > 1:
                    kept.add(number, luma, luma_of(targets[0]))
                self.on_picture("learning", number, count)
            best, rest = best_form(trials, changes[1] / max(changes[0], 1e-12))
            bank, errors = bank_of(best, solve_weights(best[0].config, best[0].total))
            about = description(best[0].config, self.reference, self.photographs, best[0].total, errors)
            if self.stages > 1 and rest > MIN_REST:
                configs = [each for each in configs if each.clips] or configs
                second, left = train_second_stage(configs, best[0], kept, count, pool, self.on_picture)
                bank, rest = replace(bank, next=second), rest * left
        found = replace(report(best[0].total, errors), clipped=float(np.mean(clipped)))
        before = {"matrix": matrix, "curve": step.get("curve"), "mode": step.get("mode")}
        return _Trained(replace(bank, about=about, **before), found, rest)  # type: ignore[arg-type]

    @cached_property
    def _matrix(self) -> np.ndarray | None:
        """The colour matrix before the bank, if it pays."""
        if len(self.reference.parts) > 1:
            return None
        pictures = ((color, targets[0]) for color, targets in map(self._filtered, self._some))
        return find_color_matrix(list(pictures), self.chroma)

    @property
    def _some(self) -> list[Photograph]:
        """Some pictures, evenly spread over all."""
        count = len(self.photographs)
        numbers = np.linspace(0, count - 1, min(MATRIX_PICTURES, count)).astype(int)
        return [self.photographs[number] for number in numbers]

    def _some_planes(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield luma of some pictures, and of the filter's results."""
        for color, targets in map(self._filtered, self._some):
            yield luma_of(color), luma_of(targets[0])

    def _filtered(self, photograph: Photograph) -> tuple[np.ndarray, list[np.ndarray]]:
        """Return a picture and the targets of the reference's parts."""
        color = photograph.color()
        return color, self.reference.apply(color, photograph)

    def _chroma_of(self, color: np.ndarray) -> list[np.ndarray]:
        """Return the chroma planes that are learned, or none."""
        return chroma_of(color) if self.chroma else []


def _ends_share(picture: np.ndarray) -> float:
    """Return the share of values that are black or white."""
    return float(((picture <= 0) | (picture >= 1)).mean())
