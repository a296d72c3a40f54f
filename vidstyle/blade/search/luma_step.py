"""Finds the step before a bank that comes nearest to a filter: a tone curve or a local mode."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from vidstyle.blade.before.local_mode import MAX_EXPONENT, MAX_MODE_RADIUS
from vidstyle.blade.before.luma_steps import luma_steps, prepare
from vidstyle.blade.before.percentile_curve import MAX_LEVEL, knots
from vidstyle.core.sampling import percentiles, sample_plane

LumaPair = tuple[np.ndarray, np.ndarray]
"""Luma of a picture and of the filter's result, H x W float32."""
StepNumbers = dict[str, np.ndarray]
"""`curve` or `mode` of a bank."""

CURVE_PERCENTILE_POSITIONS = ((0, 33, 67, 100), (1, 34, 66, 99), (2, 25, 75, 98), (5, 35, 65, 95), (0, 100))
"""Percentages of the tone curves that are tried, in addition to the measured black and white point."""
SEARCH_EXPONENT = 4
"""The exponent with which radii of the local mode are compared, and the smallest: lower ones only blur."""
MIN_FREE_SHARE = 0.1
"""The share of pixels that must not be black or white in the result, so that a tone curve is found."""


def find_luma_step(pictures: Sequence[LumaPair], with_modes: bool = True) -> tuple[StepNumbers, float]:
    """Return the step that is nearest to a filter, and the share of the change that it leaves.

    A linear function of the step's result is compared: the bank after the step learns more than that. There
    is no step, and the share is infinite, if it helps with less than half of the pictures.
    """
    change = sum(_mean_square(target - luma) for luma, target in pictures)
    found = [(step, _error(step, pictures)) for step in _curves(pictures)]
    found += [(step, _error(step, pictures)) for step in (_modes(pictures) if with_modes else ())]
    best, error = min(found, key=lambda each: each[1], default=({}, np.inf))
    if not _helps_most(best, pictures):
        return {}, np.inf  # the change of a single picture may outweigh all others
    return best, error / max(change, 1e-12)


def _helps_most(step: StepNumbers, pictures: Sequence[LumaPair]) -> bool:
    """Whether a step comes nearer to the filter than no change does, for at least half of the pictures."""
    steps = luma_steps(step.get("curve"), step.get("mode"))
    errors = [
        (_mean_square(target - prepare(luma, steps)), _mean_square(target - luma))
        for luma, target in pictures
    ]
    return 2 * sum(after < before for after, before in errors) >= len(errors)


def _modes(pictures: Sequence[LumaPair]) -> Iterator[StepNumbers]:
    """Yield local modes of the radius that is best with one exponent."""
    radii = (_mode(radius, SEARCH_EXPONENT) for radius in range(1, MAX_MODE_RADIUS + 1))
    nearest = min(radii, key=lambda step: _error(step, pictures))["mode"][0]
    for exponent in range(SEARCH_EXPONENT, MAX_EXPONENT + 1, 2):
        yield _mode(nearest, exponent)


def _mode(radius: int, exponent: int) -> StepNumbers:
    return {"mode": np.array([radius, exponent], np.int32)}


def _error(step: StepNumbers, pictures: Sequence[LumaPair]) -> float:
    """Return the sum of mean squared errors of the best linear function of a step's results."""
    steps = luma_steps(step.get("curve"), step.get("mode"))
    moments = np.zeros((3, 3))
    for luma, target in pictures:
        values = np.stack([prepare(luma, steps), target, np.ones_like(luma)]).reshape(3, -1)
        moments += values.astype(np.float64) @ values.T / luma.size
    known, wanted, both = moments[0, 0], moments[1, 1], moments[0, 1]
    means = moments[2, :2] / moments[2, 2]
    spread, covariance = known - means[0] ** 2 * moments[2, 2], both - means[0] * means[1] * moments[2, 2]
    return float(wanted - means[1] ** 2 * moments[2, 2] - covariance**2 / max(spread, 1e-12))


def _curves(pictures: Sequence[LumaPair]) -> Iterator[StepNumbers]:
    """Yield tone curves through percentiles, fitted by least squares where the result is not clipped."""
    measured = [ends for luma, target in pictures if (ends := _ends(luma, target)) is not None]
    own = [tuple(np.median(measured, axis=0).tolist())] if measured else []
    for percentages in (*CURVE_PERCENTILE_POSITIONS, *own):
        levels = _levels(percentages, pictures)
        if levels is not None:
            yield {"curve": np.column_stack([percentages, levels]).astype(np.float32)}


def _ends(luma: np.ndarray, target: np.ndarray) -> tuple[float, float] | None:
    """Return the percentages of luma that a filter makes black and white, if it stretches contrast."""
    free = _is_free(target)
    if free.mean() < MIN_FREE_SHARE or np.ptp(luma[free]) == 0:
        return None
    slope, level = np.polyfit(luma[free].astype(np.float64), target[free], 1)
    if slope <= 0:
        return None
    black, white = (100 * float((luma < each).mean()) for each in (-level / slope, (1 - level) / slope))
    return (black, white) if black < white else None


def _levels(percentages: Sequence[float], pictures: Sequence[LumaPair]) -> np.ndarray | None:
    """Return the levels of percentiles by which a curve comes nearest to the targets."""
    count = len(percentages)
    matrix, vector = 1e-6 * np.eye(count), np.zeros(count)
    for luma, target in pictures:
        free = _is_free(target)
        measured = np.minimum(percentiles(sample_plane(luma), percentages), 1)
        weights = _weights(luma[free], knots(measured))
        matrix += weights.T @ weights / luma.size
        vector += weights.T @ target[free] / luma.size
    levels = np.linalg.solve(matrix, vector)
    return levels if (np.abs(levels) <= MAX_LEVEL).all() else None


def _weights(tones: np.ndarray, ends: np.ndarray) -> np.ndarray:
    """Return the weights of the levels of a curve's points at some tones, N x points."""
    part = np.searchsorted(ends[1:-1], tones, side="right")
    share = (tones - ends[part]) / np.diff(ends)[part]
    weights = np.zeros((len(tones), len(ends)))
    weights[np.arange(len(tones)), part], weights[np.arange(len(tones)), part + 1] = 1 - share, share
    return weights


def _is_free(target: np.ndarray) -> np.ndarray:
    """Return where a result is neither black nor white."""
    return np.asarray((target > 1 / 255) & (target < 254 / 255))


def _mean_square(plane: np.ndarray) -> float:
    return float(np.square(plane, dtype=np.float64).mean())
