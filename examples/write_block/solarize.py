"""Solarization."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Slider, block


@block("pixel", on="color")
def solarize(
    picture: np.ndarray,
    threshold: Annotated[
        float, Slider(1, 254, "the brightest tone of the result", unit="levels of 255")
    ] = 128.0,
) -> np.ndarray:
    """Invert the light tones of each channel.

    min(x, t (1 - x) / (1 - t)), where t is the threshold.
    """
    t = np.float32(threshold / 255)
    return np.minimum(picture, (1 - picture) * (t / (1 - t)))
