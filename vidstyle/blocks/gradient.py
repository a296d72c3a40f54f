"""Gradient: the tones of the picture become colours."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from vidstyle.block import Color, LumaWeights, ResultRows, block
from vidstyle.core.kernels import compiled, gray_or_interleaved, interleaved


@block(
    "pixel",
    on="color",
    label="Gradient of colours",
    category="color",
    aliases="thermal, heat, infrared, false colour, duotone, tritone, gradient map, night vision, recolor",
)
def gradient(
    picture: np.ndarray,
    weights: LumaWeights,
    out: ResultRows,
    black: Annotated[Any, Color("colour of black", label="Colour of black")] = "#05010f",
    dark: Annotated[Any, Color("colour of a quarter of white", label="Colour of dark tones")] = "#5b0f8a",
    middle: Annotated[Any, Color("colour of middle gray", label="Colour of middle tones")] = "#e0412b",
    bright: Annotated[
        Any, Color("colour of three quarters of white", label="Colour of bright tones")
    ] = "#ffb01f",
    white: Annotated[Any, Color("colour of white", label="Colour of white")] = "#fffbe6",
) -> np.ndarray:
    """Give each tone its own colour, as in a thermal picture.

    A linear gradient between five colours.
    """
    colors = np.stack([black, dark, middle, bright, white]).astype(np.float32)
    _color(gray_or_interleaved(picture), weights, colors, interleaved(out))
    return out


@compiled(fastmath=True)
def _color(picture, weights, colors, out):  # type: ignore[no-untyped-def]
    zero, steps = np.float32(0), np.float32(4)
    for row in range(out.shape[0]):
        for x in range(out.shape[1] // 3):
            if picture.shape[1] < out.shape[1]:
                luma = picture[row, x]
            else:
                luma = weights[0] * picture[row, 3 * x] + weights[1] * picture[row, 3 * x + 1]
                luma += weights[2] * picture[row, 3 * x + 2]
            place = min(max(steps * luma, zero), steps)
            below = min(int(place), 3)
            part = place - np.float32(below)
            for channel in range(3):
                lower = colors[below, channel]
                out[row, 3 * x + channel] = lower + part * (colors[below + 1, channel] - lower)
