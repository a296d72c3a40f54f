"""Colorize: one hue for the whole picture."""

from __future__ import annotations

import colorsys
from functools import lru_cache
from typing import Annotated

import numpy as np

from vidstyle.block import LumaWeights, ResultRows, Slider, block
from vidstyle.core.kernels import compiled, gray_or_interleaved, interleaved


@block(
    "pixel",
    on="color",
    label="Tint",
    category="color",
    aliases=(
        "sepia, monochrome, one colour, toned, duotone, old photograph, cyanotype, warm, "
        "cold, recolor, tint, brown"
    ),
)
def colorize(
    picture: np.ndarray,
    weights: LumaWeights,
    out: ResultRows,
    hue: Annotated[
        float, Slider(0, 360, "hue: 0 red, 120 green, 240 blue", "degrees", (0, 360), label="Tint colour")
    ] = 30,
    saturation: Annotated[
        float, Slider(0, 1, "0 for gray, 1 for the pure hue", explore=(0.2, 0.8), label="Tint strength")
    ] = 0.55,
) -> np.ndarray:
    """Colour the picture in tones of one hue, as a toned photograph.

    Tones run from black through the hue to white. HSL with luma as the lightness. Paper, section 4.2 A.
    """
    _color(gray_or_interleaved(picture), weights, _difference(hue, saturation), interleaved(out))
    return out


@lru_cache(maxsize=16)
def _difference(hue: float, saturation: float) -> np.ndarray:
    """Return the RGB difference between the colour and gray, both at middle lightness."""
    pure = np.array(colorsys.hls_to_rgb(hue / 360, 0.5, 1), np.float32)
    return np.float32(saturation) * (pure - np.float32(0.5))


@compiled
def _color(picture, weights, difference, out):  # type: ignore[no-untyped-def]
    zero, one, two = np.float32(0), np.float32(1), np.float32(2)
    red, green, blue = difference[0], difference[1], difference[2]
    for row in range(out.shape[0]):
        for x in range(out.shape[1] // 3):
            if picture.shape[1] < out.shape[1]:
                luma = picture[row, x]
            else:
                luma = weights[0] * picture[row, 3 * x] + weights[1] * picture[row, 3 * x + 1]
                luma += weights[2] * picture[row, 3 * x + 2]
            luma = min(max(luma, zero), one)
            span = one - abs(two * luma - one)
            out[row, 3 * x] = luma + span * red
            out[row, 3 * x + 1] = luma + span * green
            out[row, 3 * x + 2] = luma + span * blue
