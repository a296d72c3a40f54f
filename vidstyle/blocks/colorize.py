"""Colorize: one hue for the whole picture."""

from __future__ import annotations

import colorsys
from typing import Annotated

import numpy as np

from vidstyle.block import LumaWeights, Slider, block
from vidstyle.core.kernels import compiled


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
    out = np.empty(picture.shape, np.float32)
    _color(picture, weights, np.float32(saturation) * pure, out)
    return out


@compiled
def _color(picture, weights, pure, out):  # type: ignore[no-untyped-def]
    zero, one, two = np.float32(0), np.float32(1), np.float32(2)
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            luma = weights[0] * picture[row, x, 0] + weights[1] * picture[row, x, 1]
            luma = min(max(luma + weights[2] * picture[row, x, 2], zero), one)
            span = one - abs(two * luma - one)
            for channel in range(3):
                out[row, x, channel] = luma + span * pure[channel]
