"""Makes a bank of equations."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from vidstyle.blade.bank import Bank
from vidstyle.blade.regression import (
    TrainingConfig,
    as_filters,
    clipped_of,
    constants_of,
    solve_weights,
    squared_errors,
)
from vidstyle.blade.search.trial import FilterForm


def bank_of(best: Sequence[FilterForm], weights: np.ndarray) -> tuple[Bank, np.ndarray]:
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
