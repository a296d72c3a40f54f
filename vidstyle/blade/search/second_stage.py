"""Trains the second stage of a bank, on the results of the first one."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.inference import RESAMPLING_METHOD, BankRun
from vidstyle.blade.regression import TrainingConfig, before_enlarging, solve_weights
from vidstyle.blade.search.form_bank import bank_of
from vidstyle.blade.search.trial import FOLD_COUNT, FilterForm, Trial, best_form
from vidstyle.blade.training import OnPicture
from vidstyle.core.resample import resample, scaled_shape

MIN_STAGE_GAIN = 0.1
"""The part of the error of the first stage that a second one must remove."""


@dataclass(frozen=True)
class KeptPlanes:
    """Luma and target of all pictures at the working size, kept in a folder: memory stays bounded."""

    folder: Path
    scale: float

    def add(self, number: int, luma: np.ndarray, target: np.ndarray) -> None:
        """Keep the luma and target of a picture, H x W float32."""
        shape = scaled_shape((luma.shape[0], luma.shape[1]), self.scale)
        planes = resample(luma, shape, RESAMPLING_METHOD), before_enlarging(target, shape)
        np.save(self.folder / f"{number}.npy", np.stack(planes))

    def __getitem__(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        luma, target = np.load(self.folder / f"{number}.npy")
        return luma, target


def train_second_stage(
    configs: Sequence[TrainingConfig],
    first: FilterForm,
    kept: KeptPlanes,
    count: int,
    pool: Executor,
    on_picture: OnPicture,
) -> tuple[Bank | None, float]:
    """Return the bank that filters the result of the first stage, and the share of the error that it leaves.

    The bank is None if it gains too little.
    """
    trials = [Trial(replace(config, scale=1.0), chroma=False) for config in configs]
    runs = [BankRun(bank_of([first], first.weights_without(fold))[0]) for fold in range(FOLD_COUNT)]
    for number in range(1, count + 1):
        luma, target = kept[number]
        result = runs[number % FOLD_COUNT].run(luma)
        for trial in trials:
            trial.add(number, result, [], [target], pool)
        on_picture("learning the second stage", number, count)
    best, rest = best_form(trials)
    if rest > 1 - MIN_STAGE_GAIN:
        return None, 1.0
    bank, errors = bank_of(best, solve_weights(best[0].config, best[0].total))
    about = {"samples": best[0].total.samples.tolist(), "residuals": errors.round(3).tolist()}
    return replace(bank, about=about, scale=kept.scale), rest
