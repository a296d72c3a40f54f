"""Colorize: one hue for the whole picture."""

from __future__ import annotations

import colorsys
from typing import Annotated

import numpy as np

from vidstyle.block import LumaWeights, Slider, block


@block("pixel", on="color")
def colorize(
    picture: np.ndarray,
    weights: LumaWeights,
    hue: Annotated[float, Slider(0, 360, "hue: 0 red, 120 green, 240 blue", "degrees", (0, 360))] = 30,
    saturation: Annotated[float, Slider(0, 1, "0 for gray, 1 for the pure hue", explore=(0.2, 0.8))] = 0.55,
) -> np.ndarray:
    """Convert to tones of one hue, from black over the hue to white.

    HSL with luma as its lightness. Paper, section 4.2 A.
    """
    pure = np.array(colorsys.hls_to_rgb(hue / 360, 0.5, 1), np.float32) - np.float32(0.5)
    lightness = np.clip(picture @ weights, 0, 1)
    span = (1 - np.abs(2 * lightness - 1)) * np.float32(saturation)
    return lightness[..., None] + span[..., None] * pure
