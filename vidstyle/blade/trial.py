"""Trains several layouts of a bank on the same pictures and keeps the best."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.photographs import Photograph, chroma_of, luma_of
from vidstyle.blade.reference_filter import ReferenceFilter
from vidstyle.blade.regression import (
    NormalEquations,
    TrainingConfig,
    accumulate,
    as_filters,
    constants_of,
    solve_weights,
    squared_errors,
    with_gains,
    with_sums,
)
from vidstyle.blade.training import OnPicture, TrainingReport, description, report
from vidstyle.core.machine.cores import available_cores

FOLD_COUNT = 3
"""Groups of pictures, each of which checks the filters that are learned from the others."""
MIN_AFFINE_GAIN = 0.02
"""The part of the change that affine filters must explain in addition to filters that keep flat areas."""
MIN_LAYOUT_GAIN = 0.005
"""The part of the change that a layout must explain in addition to an earlier, simpler one."""


@dataclass(frozen=True)
class FilterForm:
    """Equations of filters of one form, of luma or chroma.

    Attributes:
        config: the form of the filters.
        folds: the equations of each group of pictures.
    """

    config: TrainingConfig
    folds: tuple[NormalEquations, ...]

    @property
    def errors(self) -> float:
        """The sum of squared errors on each group of pictures, after learning from the others."""
        groups = [fold for fold in self.folds if fold.samples.any()]
        return sum(self._errors(groups, number) for number in range(len(groups)))

    def _errors(self, groups: Sequence[NormalEquations], number: int) -> float:
        others = [each for each in groups if each is not groups[number]] or groups
        weights = solve_weights(self.config, self._total(others))
        return float(np.maximum(squared_errors(groups[number], weights), 0).sum())

    @property
    def energy(self) -> float:
        """The sum of squared targets."""
        return float(sum(fold.energies.sum() for fold in self.folds))

    @property
    def total(self) -> NormalEquations:
        """The equations of all pictures."""
        return self._total(self.folds)

    def _total(self, groups: Sequence[NormalEquations]) -> NormalEquations:
        total = NormalEquations.empty(self.config)
        for each in groups:
            total.add(each)
        return total

    def constrained(self, config: TrainingConfig) -> FilterForm:
        """Return the same with the sums of `config` instead of affine filters."""
        folds = tuple(with_sums(config, fold)[1] for fold in self.folds)
        return FilterForm(replace(config, affine=False), folds)


class Trial:
    """Sums up the equations of one layout, for luma and optionally chroma."""

    def __init__(self, config: TrainingConfig, chroma: bool) -> None:
        configs = [
            replace(config, affine=True),
            *([replace(config, affine=True, planes=2)] if chroma else []),
        ]
        self._affine = [
            FilterForm(each, tuple(NormalEquations.empty(each) for _ in range(FOLD_COUNT)))
            for each in configs
        ]

    def add(self, number: int, color: np.ndarray, targets: Sequence[np.ndarray], pool: Executor) -> None:
        """Add a picture, RGB, with its number, and the target of each part."""
        of_luma, *of_chroma = self._affine
        luma, wanted, fold = luma_of(color), [luma_of(each) for each in targets], number % FOLD_COUNT
        of_luma.folds[fold].add(accumulate(of_luma.config, luma, wanted, pool))
        for each in of_chroma:
            planes = zip(chroma_of(color), *map(chroma_of, targets), strict=True)
            for place, (plane, *wanted) in enumerate(planes):
                each.folds[fold].add(accumulate(each.config, luma, wanted, pool, plane, place))

    def forms(self) -> Iterator[list[FilterForm]]:
        """Yield the forms for luma and chroma: with the sums of the reference's parts, and affine."""
        of_luma, *of_chroma = self._affine
        gains = (with_gains(each.config, each.total) for each in of_chroma)
        yield [
            of_luma.constrained(of_luma.config),
            *(each.constrained(config) for each, config in zip(of_chroma, gains, strict=True)),
        ]
        yield self._affine

    @property
    def change(self) -> float:
        """The sum of squared changes by the reference."""
        of_luma, *of_chroma = self._affine
        kept = [replace(each.config, sums=(1.0,) * len(each.config.sums)) for each in of_chroma]
        found = [of_luma.constrained(of_luma.config), *map(FilterForm.constrained, of_chroma, kept)]
        return sum(each.energy for each in found)


def train_best(
    configs: Sequence[TrainingConfig],
    reference: ReferenceFilter,
    photographs: Sequence[Photograph],
    on_picture: OnPicture = lambda *_: None,
    chroma: bool = False,
) -> tuple[Bank, TrainingReport]:
    """Train a bank of the layout that explains most of the change; with `chroma` also for the chroma planes.

    Each layout is trained on two thirds of the pictures and checked on the others, in turn, with filters that
    keep flat areas flat and with affine ones. The best is then trained on all pictures.

    Args:
        configs: the layouts, simpler ones first; a later one must be better by `MIN_LAYOUT_GAIN`.

    Raises:
        InputError: a picture cannot be read, or the reference filter fails.
        UsageError: the reference filter's settings are invalid.
    """
    trials = [Trial(config, chroma) for config in configs]
    clipped = []
    with ThreadPoolExecutor(available_cores()) as pool:
        for number, photograph in enumerate(photographs, 1):
            color = photograph.color()
            targets = reference.apply(color, photograph)
            clipped.append(_ends_share(targets[0]) - _ends_share(color))
            for trial in trials:
                trial.add(number, color, targets, pool)
            on_picture("learning", number, len(photographs))
    best = _best(trials)
    sums = best[0].total
    weights = solve_weights(best[0].config, sums)
    with np.errstate(invalid="ignore"):
        mean = squared_errors(sums, weights) / sums.samples
    errors = 255 * np.sqrt(np.maximum(np.nan_to_num(mean), 0))
    about = description(best[0].config, reference, photographs, sums, errors)
    return _bank(best, weights, about), replace(report(sums, errors), clipped=float(np.mean(clipped)))


def _ends_share(picture: np.ndarray) -> float:
    """Return the share of values that are black or white."""
    return float(((picture <= 0) | (picture >= 1)).mean())


def _best(trials: Sequence[Trial]) -> list[FilterForm]:
    """Return the forms for luma and chroma of the best layout."""
    best: list[FilterForm] = []
    least = np.inf
    for trial in trials:
        for form, needed in zip(trial.forms(), (MIN_LAYOUT_GAIN, MIN_AFFINE_GAIN), strict=True):
            unexplained = sum(each.errors for each in form) / max(trial.change, 1e-12)
            if unexplained < least - needed:
                best, least = form, unexplained
    return best


def _bank(best: list[FilterForm], weights: np.ndarray, about: dict[str, object]) -> Bank:
    of_luma, *of_chroma = best
    config = of_luma.config
    found = [(config, weights)]
    found += [(each.config, solve_weights(each.config, each.total)) for each in of_chroma]
    filters = [as_filters(*each) for each in found]
    constants = [each for pair in found if (each := constants_of(*pair)) is not None]
    return Bank(
        config.bins,
        config.rho,
        filters[0],
        about,
        filters[1] if of_chroma else None,
        np.concatenate(constants, axis=2) if constants else None,
        config.scale,
    )
