"""Trains the best of several layouts of a bank, in one or two stages."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.inference import RESAMPLING_METHOD, BankRun
from vidstyle.blade.photographs import Photograph, luma_of
from vidstyle.blade.reference_filter import ReferenceFilter
from vidstyle.blade.regression import (
    TrainingConfig,
    as_filters,
    before_enlarging,
    clipped_of,
    constants_of,
    solve_weights,
    squared_errors,
)
from vidstyle.blade.search.color_matrix import find_color_matrix, square_of
from vidstyle.blade.search.trial import FOLD_COUNT, FilterForm, Trial, best_form
from vidstyle.blade.training import OnPicture, TrainingReport, description, report
from vidstyle.core.color.deferred_color import Mixed
from vidstyle.core.machine.cores import available_cores
from vidstyle.core.resample import resample, scaled_shape

MAX_SEARCH_SIZE_PX = 7
"""Size of filters above which only the layouts that are best at this size are trained."""
MIN_STAGE_GAIN = 0.1
"""The part of the error of the first stage that a second one must remove."""
MATRIX_PICTURES = 6
"""Maximum number of pictures from which a colour matrix is found; they are in memory at the same time."""
MIN_REST = 0.05
"""The part of the change that the first stage must leave so that a second one is tried."""


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
    the filter mixes colours, a colour matrix comes first. Layouts of large filters are compared with smaller
    ones: the time of training grows with the square of their area.

    Args:
        configs: the layouts, simpler ones first; a later one must be better by `MIN_LAYOUT_GAIN`.
        stages: maximum number of stages, 1 or 2; banks of several parts have one.

    Raises:
        InputError: a picture cannot be read, or the reference filter fails.
        UsageError: the reference filter's settings are invalid.
    """
    if len(configs) > 1 and configs[0].size > MAX_SEARCH_SIZE_PX:
        small = [replace(each, size=MAX_SEARCH_SIZE_PX) for each in configs]
        bank, _ = train_best(small, reference, photographs, on_picture, chroma, stages)
        layouts = [(each.bins, each.clips) for each in bank.stages]
        configs = [each for each in configs if (each.bins, each.clips) in layouts]
    trials, clipped = [Trial(config, chroma) for config in configs], []
    is_single = len(reference.parts) == 1
    stages = stages if is_single else 1
    known = _spread(photographs, MATRIX_PICTURES if is_single else 0, reference)
    matrix = find_color_matrix([(color, targets[0]) for color, targets in known.values()], chroma)
    changes = np.zeros(2)
    with ThreadPoolExecutor(available_cores()) as pool, TemporaryDirectory() as folder:
        kept = KeptPlanes(Path(folder), configs[0].scale)
        for number, photograph in enumerate(photographs, 1):
            is_known = photograph in known
            color, targets = known.pop(photograph) if is_known else _filtered(photograph, reference)
            clipped.append(_ends_share(targets[0]) - _ends_share(color))
            changes[0] += square_of(targets[0], color, chroma)
            color = color if matrix is None else Mixed(color, matrix).whole()
            changes[1] += square_of(targets[0], color, chroma)
            for trial in trials:
                trial.add(number, color, targets, pool)
            if stages > 1:
                kept.add(number, luma_of(color), luma_of(targets[0]))
            on_picture("learning", number, len(photographs))
        best, rest = best_form(trials, changes[1] / max(changes[0], 1e-12))
        bank, errors = _bank(best, solve_weights(best[0].config, best[0].total))
        about = description(best[0].config, reference, photographs, best[0].total, errors)
        if stages > 1 and rest > MIN_REST:
            configs = [each for each in configs if each.clips] or configs
            bank = replace(
                bank, next=_second_stage(configs, best[0], kept, len(photographs), pool, on_picture)
            )
    found = replace(report(best[0].total, errors), clipped=float(np.mean(clipped)))
    return replace(bank, about=about, matrix=matrix), found


def _filtered(photograph: Photograph, reference: ReferenceFilter) -> tuple[np.ndarray, list[np.ndarray]]:
    """Return a picture and the targets of the reference's parts."""
    color = photograph.color()
    return color, reference.apply(color, photograph)


def _spread(
    photographs: Sequence[Photograph], count: int, reference: ReferenceFilter
) -> dict[Photograph, tuple[np.ndarray, list[np.ndarray]]]:
    """Return some pictures and their targets, evenly spread over all."""
    numbers = np.linspace(0, len(photographs) - 1, min(count, len(photographs))).astype(int)
    return {photographs[number]: _filtered(photographs[number], reference) for number in numbers}


def _second_stage(
    configs: Sequence[TrainingConfig],
    first: FilterForm,
    kept: KeptPlanes,
    count: int,
    pool: Executor,
    on_picture: OnPicture,
) -> Bank | None:
    """Return the bank that filters the result of the first stage, or None if it gains too little."""
    trials = [Trial(replace(config, scale=1.0), chroma=False) for config in configs]
    runs = [BankRun(_bank([first], first.weights_without(fold))[0]) for fold in range(FOLD_COUNT)]
    for number in range(1, count + 1):
        luma, target = kept[number]
        result = runs[number % FOLD_COUNT].run(luma)
        for trial in trials:
            trial.add(number, result, [target], pool)
        on_picture("learning the second stage", number, count)
    best, rest = best_form(trials)
    if rest > 1 - MIN_STAGE_GAIN:
        return None
    bank, errors = _bank(best, solve_weights(best[0].config, best[0].total))
    about = {"samples": best[0].total.samples.tolist(), "residuals": errors.round(3).tolist()}
    return replace(bank, about=about, scale=kept.scale)


def _ends_share(picture: np.ndarray) -> float:
    """Return the share of values that are black or white."""
    return float(((picture <= 0) | (picture >= 1)).mean())


def _bank(best: Sequence[FilterForm], weights: np.ndarray) -> tuple[Bank, np.ndarray]:
    """Return a bank of these unknowns for luma, and the errors of each part and bin, in levels of 255."""
    of_luma, *of_chroma = best
    config = of_luma.config
    found = [(config, weights), *_solved(of_chroma)]
    filters = [as_filters(*each) for each in found]
    constants = [each for pair in found if (each := constants_of(*pair)) is not None]
    bank = Bank(
        config.bins,
        config.rho,
        filters[0],
        {},
        filters[1] if of_chroma else None,
        np.concatenate(constants, axis=2) if constants else None,
        config.scale,
        config.clips,
        clipped_of(config, weights),
    )
    with np.errstate(invalid="ignore"):
        mean = squared_errors(of_luma.total, weights) / of_luma.total.samples
    return bank, 255 * np.sqrt(np.maximum(np.nan_to_num(mean), 0))


def _solved(forms: Sequence[FilterForm]) -> Iterator[tuple[TrainingConfig, np.ndarray]]:
    for each in forms:
        yield each.config, solve_weights(each.config, each.total)
