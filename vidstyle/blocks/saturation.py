"""Saturation."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated

import numpy as np

from vidstyle.block import LumaWeights, ResultRows, Slider, block
from vidstyle.core.kernels import mix_channels


@block("pixel", on="color")
def saturation(
    picture: np.ndarray,
    weights: LumaWeights,
    out: ResultRows,
    factor: Annotated[
        float, Slider(0, 4, "0 for gray, 1 for no change, above 1 more vivid", explore=(1.5, 2.2))
    ] = 1.8,
) -> np.ndarray:
    """Make the colours more vivid or more muted.

    gray + factor (RGB - gray), clipped to 0..1. Paper, section 4.2 A.
    """
    return mix_channels(picture, _matrix(factor, tuple(weights)), out)


@lru_cache(maxsize=16)
def _matrix(factor: float, weights: tuple[np.float32, ...]) -> np.ndarray:
    matrix = factor * np.eye(3, 4)
    matrix[:, :3] += (1 - factor) * np.array(weights)
    return matrix.astype(np.float32)
