"""Linear histogram equalization."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Annotated, NamedTuple

import numpy as np

from vidstyle.block import Percentiles, ResultRows, Slider, block
from vidstyle.core.kernels import compiled

MIN_RANGE = 8 / 255
"""Minimum range of luma, so that black frames and fades are not amplified into noise."""
MIDDLE_PERCENTILE_RANGE = 35, 65
"""Percentiles whose mean is the middle tone of a picture; the median alone
jumps where half of a picture is black."""
MAX_DIM_LUMA = 0.35
"""Middle tone below which a picture is dim, after the stretch of contrast. Tuned, as the numbers below, on 16
photographs: people in dim rooms, a wood in shade, deep blue skies, stages, streets at night."""
MAX_LIFT_GAIN = 3.0
"""Largest gain of dark tones, so that night stays night and its noise stays dark."""
BLACK_LUMA_LEVEL = 0.03
"""Luma around which tones are lifted half: black stays black."""
DARKEST_LUMA_RANGE, SHARE_OF_DARKEST = (0.04, 0.16), 2.0
"""Darkest luma of pictures without black, such as of a sky; and how much of it, beyond the start of the
range, stays, relative to the lift."""

LIFT_CONTROL = Slider(
    0, 1, "how much a dim picture is brightened; 0 for a stretch only", label="Brighter if dim"
)
DEFAULT_LIFT_AMOUNT = 0.6


@block(
    "measured",
    on="luma",
    percentiles=lambda low, high: (low, *MIDDLE_PERCENTILE_RANGE, high),
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
    lift: Annotated[float, LIFT_CONTROL] = DEFAULT_LIFT_AMOUNT,
    settle: Annotated[
        float,
        Slider(0, 10, "time constant of temporal smoothing; 0 for none", "s", label="Smoothing over time"),
    ] = 0.4,
) -> np.ndarray:
    """Stretch the contrast, so that the darkest parts become black and the brightest white.

    Luma is stretched from a low to a high percentile. A range below 8 levels of 255 counts as 8. Paper,
    section 4.2 D, but measured on a reduced copy. With `lift`, the darkest part of a picture without
    black, such as of a blue sky, does not become black, and a dim picture gets more light: if its middle
    tone m, the mean of percentiles 35 and 65, is below 0.35 after the stretch, tones rise along x +
    k x^2 (1 - x) / ((x + 0.03) (1 + k x)). Without the 0.03, and unless k is limited to 2, m rises by the
    share `lift` of its distance.
    """
    black, *middle, white = measured
    return ToneStretch.between(black, white, lift).apply(luma, middle, lift, out)


class ToneStretch(NamedTuple):
    """A stretch of contrast: luma becomes level + gain * (luma - center), within `limits`."""

    center: float
    gain: float
    level: float
    limits: tuple[float, float] = (0.0, 1.0)

    @classmethod
    def between(cls, black: float, white: float, lift: float) -> ToneStretch:
        """Return the stretch to black and white; `lift` keeps a picture without black from black."""
        least, most = DARKEST_LUMA_RANGE
        level = min(SHARE_OF_DARKEST * lift, 1.0) * (min(max(black, least), most) - least)
        return cls(black, (1 - level) / max(white - black, MIN_RANGE), level)

    def growth(self, middle: Sequence[float], lift: float) -> float:
        """Return how much the gain of dark tones exceeds 1, for the percentiles around the middle tone."""
        tone = min(max((sum(middle) / len(middle) - self.center) * self.gain + self.level, 0.0), 1.0)
        risen = tone + lift * max(MAX_DIM_LUMA - tone, 0.0)
        gain = risen * (1 - tone) / max(tone * (1 - risen), 1e-3) if risen > tone else 1.0
        return min(gain, MAX_LIFT_GAIN) - 1

    def apply(self, luma: np.ndarray, middle: Sequence[float], lift: float, out: np.ndarray) -> np.ndarray:
        """Stretch luma and brighten a dim picture; written to `out`."""
        center, gain, level, growth = map(np.float32, (*self[:3], self.growth(middle, lift)))
        low, high = map(np.float32, self.limits)
        _stretch_and_lift(luma, center, gain, level, low, high, growth, out)
        return out


NO_STRETCH = ToneStretch(0.0, 1.0, 0.0, (-math.inf, math.inf))
"""Keeps luma, including highlights above white."""


def lifted(tone: np.ndarray, growth: float) -> np.ndarray:
    """Return tones of a stretched picture, 0..1, as `ToneStretch.apply` brightens them by this growth."""
    return tone + growth * tone**2 * (1 - tone) / ((tone + BLACK_LUMA_LEVEL) * (1 + growth * tone))


@compiled
def _stretch_and_lift(luma, center, gain, level, low, high, growth, out):  # type: ignore[no-untyped-def]
    zero, one, black = np.float32(0), np.float32(1), np.float32(BLACK_LUMA_LEVEL)
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            stretched = min(max((luma[row, x] - center) * gain + level, low), high)
            tone = min(max(stretched, zero), one)
            risen = growth * tone * tone * (one - tone)
            out[row, x] = stretched + risen / ((tone + black) * (one + growth * tone))
