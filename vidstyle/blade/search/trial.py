"""Compares layouts of a bank by cross-validation on the same pictures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from vidstyle.blade.photographs import chroma_of, luma_of
from vidstyle.blade.regression import (
    NormalEquations,
    TrainingConfig,
    accumulate,
    solve_weights,
    squared_errors,
    with_gains,
    with_sums,
)
from vidstyle.core.bands import threads_for
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
        numbers = [number for number, fold in enumerate(self.folds) if fold.samples.any()]
        with threads_for(min(available_cores(), len(numbers)), "vidstyle-folds") as pool:
            return sum(pool.map(self._errors, numbers))

    def _errors(self, number: int) -> float:
        return float(np.maximum(squared_errors(self.folds[number], self.weights_without(number)), 0).sum())

    def weights_without(self, number: int) -> np.ndarray:
        """Return the unknowns learned from all groups of pictures but one, or from the only one."""
        groups = [fold for fold in self.folds if fold.samples.any()]
        others = [each for each in groups if each is not self.folds[number]] or groups
        return solve_weights(self.config, self._total(others))

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
            *([replace(config, affine=True, planes=2, clips=())] if chroma else []),
        ]
        self._affine = [
            FilterForm(each, tuple(NormalEquations.empty(each) for _ in range(FOLD_COUNT)))
            for each in configs
        ]

    def add(
        self,
        number: int,
        luma: np.ndarray,
        chroma: Sequence[np.ndarray],
        targets: Sequence[np.ndarray],
        pool: Executor,
    ) -> None:
        """Add the planes of a picture with its number, H x W float32, and the target of each part."""
        of_luma, *of_chroma = self._affine
        wanted, fold = [luma_of(each) for each in targets], number % FOLD_COUNT
        of_luma.folds[fold].add(accumulate(of_luma.config, luma, wanted, pool))
        for each in of_chroma:
            planes = zip(chroma, *map(chroma_of, targets), strict=True)
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


def best_form(trials: Sequence[Trial], share: float = 1.0) -> tuple[list[FilterForm], float]:
    """Return the forms of the best layout for luma and chroma, and the share of the change they leave.

    Args:
        share: the share of the filter's change that is left for the banks, after a colour matrix.
    """
    best: list[FilterForm] = []
    least = np.inf
    for trial in trials:
        for form in trial.forms():
            begins_affine = form[0].config.affine and not (best and best[0].config.affine)
            needed = MIN_AFFINE_GAIN if begins_affine else MIN_LAYOUT_GAIN
            unexplained = share * sum(each.errors for each in form) / max(trial.change, 1e-12)
            if unexplained < least - needed:
                best, least = form, unexplained
    return best, float(least)
