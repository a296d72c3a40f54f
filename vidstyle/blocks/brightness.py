"""Brightness."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import ResultRows, Slider, block
from vidstyle.blocks.equalize import stretch


@block(
    "pixel",
    on="luma",
    label="Brightness",
    category="tone",
    aliases="exposure, lighten, lighter, darken, darker, gain, light, shadows, highlights, gamma, gloomy",
)
def brightness(
    luma: np.ndarray,
    out: ResultRows,
    factor: Annotated[
        float,
        Slider(
            0,
            4,
            "below 1 darker, above 1 brighter: a factor for luma",
            explore=(0.8, 1.4),
            label="Brightness",
        ),
    ] = 1.3,
) -> np.ndarray:
    """Make the picture brighter or darker.

    Luma is multiplied by a factor and clipped to black and white. Paper, section 4.2 A.
    """
    return stretch(luma, 0, factor, 0, out)
