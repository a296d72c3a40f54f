"""Saturation."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated

import numpy as np

from vidstyle.block import LumaWeights, Slider, block
from vidstyle.core.color.deferred_color import Mixed


@block(
    "pixel",
    on="color",
    label="Colour strength",
    category="color",
    aliases=(
        "saturation, vibrance, vivid, vibrant, desaturate, muted, pale, colourful, colorful, gray, "
        "black and white, washed out, punchy, dull, colourless, rainbow"
    ),
)
def saturation(
    picture: np.ndarray,
    weights: LumaWeights,
    factor: Annotated[
        float,
        Slider(
            0,
            4,
            "0 for gray, 1 for no change, above 1 for more vivid colours",
            explore=(1.5, 2.2),
            label="Colour strength",
        ),
    ] = 1.8,
) -> Mixed:
    """Make colours more vivid or more muted.

    gray + factor (RGB - gray), clipped to 0..1, except highlights of HDR. Paper, section 4.2 A.
    """
    return Mixed(picture, _matrix(factor, tuple(weights)))


@lru_cache(maxsize=16)
def _matrix(factor: float, weights: tuple[np.float32, ...]) -> np.ndarray:
    matrix = factor * np.eye(3, 4)
    matrix[:, :3] += (1 - factor) * np.array(weights)
    return matrix.astype(np.float32)
