"""Inversion: a negative, or solarization."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import ResultRows, Slider, block
from vidstyle.core.kernels import TIE_LIFT


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
    np.copyto(out, picture)
    chosen = picture + TIE_LIFT >= np.float32(above / 255)
    np.subtract(np.float32(1), picture, out=out, where=chosen)
    return out
