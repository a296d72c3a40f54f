"""Posterization: a few flat tones in each channel."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Slider, block


@block("pixel", on="channels")
def posterize(
    picture: np.ndarray,
    levels: Annotated[int, Slider(2, 32, "tones left in each channel", explore=(5, 12))] = 10,
) -> np.ndarray:
    """Reduce each channel to a few flat tones."""
    return np.minimum(np.floor(picture * levels), levels - 1) / (levels - 1)
