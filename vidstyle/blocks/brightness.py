"""Brightness."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import ResultRows, Slider, block
from vidstyle.core.kernels import compiled


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
    _scale(luma, np.float32(factor), out)
    return out


@compiled
def _scale(luma, factor, out):  # type: ignore[no-untyped-def]
    zero, one = np.float32(0), np.float32(1)
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            out[row, x] = min(max(luma[row, x] * factor, zero), one)
