"""Inversion: a negative, or solarization."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import ResultRows, Slider, block
from vidstyle.core.kernels import TIE_LIFT, compiled, interleaved


@block(
    "pixel",
    on="channels",
    label="Invert",
    category="tone",
    aliases="negative, solarize, solarization, x-ray, opposite colours, sabattier",
)
def invert(
    picture: np.ndarray,
    out: ResultRows,
    above: Annotated[
        float,
        Slider(0, 255, "darkest tone to invert; 0 inverts all tones", "of 255", label="Invert above"),
    ] = 0,
) -> np.ndarray:
    """Turn the picture into a negative, or solarize it if dark tones are kept.

    Each channel is inverted.
    """
    _invert(interleaved(picture), TIE_LIFT, np.float32(above / 255), interleaved(out))
    return out


@compiled
def _invert(values, lift, darkest, out):  # type: ignore[no-untyped-def]
    for row in range(values.shape[0]):
        for x in range(values.shape[1]):
            level = values[row, x]
            out[row, x] = np.float32(1) - level if level + lift >= darkest else level
