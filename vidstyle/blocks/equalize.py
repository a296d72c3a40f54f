"""Linear histogram equalization."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Percentiles, ResultRows, Slider, block
from vidstyle.core.kernels import compiled

MIN_RANGE = 8 / 255
"""Minimum range of luma, so that black frames and fades are not amplified into noise."""


@block(
    "measured",
    on="luma",
    percentiles=lambda low, high: (low, high),
    label="Automatic contrast",
    category="tone",
    aliases=(
        "levels, curves, auto levels, normalize, histogram, stretch, tones, black point, white point, "
        "shadows, highlights, fade"
    ),
)
def equalize(
    luma: np.ndarray,
    measured: Percentiles,
    out: ResultRows,
    low: Annotated[
        float, Slider(0, 50, "percentile that becomes black", "percent", (1, 10), label="Black point")
    ] = 5,
    high: Annotated[
        float, Slider(50, 100, "percentile that becomes white", "percent", (90, 99), label="White point")
    ] = 95,
    settle: Annotated[
        float,
        Slider(0, 10, "time constant of temporal smoothing; 0 for none", "s", label="Smoothing over time"),
    ] = 0.4,
) -> np.ndarray:
    """Stretch the contrast, so that the darkest parts become black and the brightest white.

    Luma is stretched from a low to a high percentile. A range below 8 levels of 255 counts as 8. Paper,
    section 4.2 D, but measured on a reduced copy.
    """
    black, white = measured
    return stretch(luma, black, 1 / max(white - black, MIN_RANGE), 0, out)


def stretch(luma: np.ndarray, center: float, gain: float, level: float, out: np.ndarray) -> np.ndarray:
    """Scale luma about a center, move the center to another level, and clip to 0..1; written to `out`."""
    _stretch(luma, np.float32(center), np.float32(gain), np.float32(level), out)
    return out


@compiled
def _stretch(luma, center, gain, level, out):  # type: ignore[no-untyped-def]
    zero, one = np.float32(0), np.float32(1)
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            out[row, x] = min(max((luma[row, x] - center) * gain + level, zero), one)
