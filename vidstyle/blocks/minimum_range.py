"""Histogram minimum dynamic range."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Percentiles, ResultRows, Slider, block
from vidstyle.blocks.equalize import (
    DEFAULT_LIFT_AMOUNT,
    LIFT_CONTROL,
    MIDDLE_PERCENTILE_RANGE,
    MIN_RANGE,
    NO_STRETCH,
    ToneStretch,
)


@block(
    "measured",
    on="luma",
    percentiles=lambda: (5, *MIDDLE_PERCENTILE_RANGE, 95),
    label="Contrast boost",
    category="tone",
    aliases=(
        "dynamic range, dull pictures, haze, foggy, faded, flat light, "
        "levels, shadows, highlights, washed out, punchy"
    ),
)
def minimum_range(
    luma: np.ndarray,
    measured: Percentiles,
    out: ResultRows,
    dynamic_range: Annotated[
        float,
        Slider(
            0,
            255,
            "minimum distance between the 5 % and 95 % percentiles",
            "of 255",
            (100, 200),
            label="Contrast",
        ),
    ] = 180,
    lift: Annotated[float, LIFT_CONTROL] = DEFAULT_LIFT_AMOUNT,
    settle: Annotated[
        float,
        Slider(0, 10, "time constant of temporal smoothing; 0 for none", "s", label="Smoothing over time"),
    ] = 0.4,
) -> np.ndarray:
    """Give a flat, hazy picture more contrast, and a dim one more light; others stay unchanged.

    The dynamic range of luma is expanded to a minimum. The range expands about its middle, which moves
    only as far as needed to keep the new range between black and white. A range below 8 levels of 255
    counts as 8. Paper, section 4.2 D, but measured on a reduced copy. Then `lift` brightens a dim picture, as
    in `equalize`.
    """
    dark, *tones, bright = measured
    wanted = dynamic_range / 255
    present = max(bright - dark, MIN_RANGE)
    middle = (dark + bright) / 2
    moved = min(max(middle, wanted / 2), 1 - wanted / 2)
    stretch = ToneStretch(middle, wanted / present, moved) if present < wanted else NO_STRETCH
    return stretch.apply(luma, tones, lift, out)
