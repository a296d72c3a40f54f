"""Linear histogram equalization."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Measured, Slider, block

MIN_RANGE = 8 / 255
"""A smaller range counts as this, so that black frames and fades do not turn into noise."""


def _percentiles(low: float, high: float) -> tuple[float, float]:
    return low, high


@block("measured", on="luma", percentiles=_percentiles)
def equalize(
    luma: np.ndarray,
    measured: Measured,
    low: Annotated[float, Slider(0, 50, "this much of the picture turns black", "percent", (1, 10))] = 5,
    high: Annotated[float, Slider(50, 100, "the rest above this turns white", "percent", (90, 99))] = 95,
    settle: Annotated[float, Slider(0, 10, "time in which it follows a change; 0 is at once", "s")] = 0.4,
) -> np.ndarray:
    """Stretch luma from the dark percentile to the bright one over the whole range.

    A range of less than 8 levels of 255 counts as 8. Paper, section 4.2 D.
    """
    black, white = measured
    gain = 1 / max(white - black, MIN_RANGE)
    out = np.subtract(luma, np.float32(black))
    out *= np.float32(gain)
    return np.clip(out, 0, 1, out=out)
