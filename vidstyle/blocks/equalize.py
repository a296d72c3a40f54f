"""Linear histogram equalization."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Measured, Slider, block

MIN_RANGE = 8 / 255
"""The least range of luma: black frames and fades are not amplified into noise."""


@block("measured", on="luma", percentiles=lambda low, high: (low, high))
def equalize(
    luma: np.ndarray,
    measured: Measured,
    low: Annotated[float, Slider(0, 50, "percentile that becomes black", "percent", (1, 10))] = 5,
    high: Annotated[float, Slider(50, 100, "percentile that becomes white", "percent", (90, 99))] = 95,
    settle: Annotated[float, Slider(0, 10, "time constant of temporal smoothing; 0 for none", "s")] = 0.4,
) -> np.ndarray:
    """Stretch luma so that a low percentile becomes black and a high one white.

    A range of less than 8 levels of 255 counts as 8. Paper, section 4.2 D, but of a reduced copy.
    """
    black, white = measured
    gain = 1 / max(white - black, MIN_RANGE)
    out = np.subtract(luma, np.float32(black))
    out *= np.float32(gain)
    return np.clip(out, 0, 1, out=out)
