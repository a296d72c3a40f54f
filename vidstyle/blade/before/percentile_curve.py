"""A tone curve through percentiles of the picture, on which automatic contrast and equalization are based."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Percentiles, ResultRows, Slider, Switch, block
from vidstyle.core.kernels import compiled

MIN_GAP = 2 / 255
"""Minimum distance of two percentiles, so that black frames and fades are not amplified into noise."""
SETTLE_SECONDS = 0.4
"""Time constant of the smoothing of percentiles over time."""
MAX_LEVEL = 4.0
"""Maximum size of the level of a percentile; levels beyond 0..1 are clipped."""
KNOT_NAMES = ("dark", "low", "high", "bright")
"""Parameters of the percentiles; with the prefix `level_`, of their levels."""
Percentage = Annotated[float, Slider(0, 100, "percentile of luma", "percent")]
Level = Annotated[float, Slider(-MAX_LEVEL, MAX_LEVEL, "luma that the percentile becomes")]


@block("measured", on="luma", percentiles=lambda dark, low, high, bright: (dark, low, high, bright))
def percentile_curve(
    luma: np.ndarray,
    measured: Percentiles,
    out: ResultRows,
    dark: Percentage = 5,
    low: Percentage = 35,
    high: Percentage = 65,
    bright: Percentage = 95,
    level_dark: Level = 0,
    level_low: Level = 0.3,
    level_high: Level = 0.7,
    level_bright: Level = 1,
    straight: Annotated[bool, Switch("place low and high at thirds from dark to bright")] = False,
    amount: Annotated[float, Slider(0, 1, "0 for no effect")] = 1,
    settle: Annotated[
        float, Slider(0, 10, "time constant of temporal smoothing; 0 for none", "s")
    ] = SETTLE_SECONDS,
) -> np.ndarray:
    """Map four percentiles of luma to levels, with straight lines between and beyond them; clip to 0..1.

    If `straight`, the two inner points are at thirds between the outer percentiles. A distance of two points
    below 2 levels of 255 counts as 2.
    """
    ends = knots(measured, straight)
    levels = np.array([level_dark, level_low, level_high, level_bright])
    slopes = (np.diff(levels) / np.diff(ends)).astype(np.float32)
    _curve(luma, ends.astype(np.float32), levels.astype(np.float32), slopes, np.float32(amount), out)
    return out


def knots(measured: np.ndarray, straight: bool = False) -> np.ndarray:
    """Return the tones of the points of a curve with at least `MIN_GAP` from each to the next, float64.

    >>> knots(np.array([0.1, 0.1, 0.5, 0.6])).round(4).tolist()
    [0.1, 0.1078, 0.5, 0.6]
    >>> knots(np.array([0, 0.1, 0.5, 0.6]), straight=True).round(4).tolist()
    [0.0, 0.2, 0.4, 0.6]
    """
    if straight:
        measured = np.linspace(measured[0], measured[-1], len(measured))
    gaps = MIN_GAP * np.arange(len(measured))
    return np.asarray(np.maximum.accumulate(measured - gaps) + gaps, np.float64)


@compiled
def _curve(luma, ends, levels, slopes, amount, out):  # type: ignore[no-untyped-def]
    zero, one = np.float32(0), np.float32(1)
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            own = luma[row, x]
            part = np.int32(own >= ends[1]) + np.int32(own >= ends[2])
            tone = levels[part] + (own - ends[part]) * slopes[part]
            out[row, x] = own + amount * (min(max(tone, zero), one) - own)
