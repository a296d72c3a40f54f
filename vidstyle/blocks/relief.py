"""Relief: luma as a height, lit from the side."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from vidstyle.block import Slider, block
from vidstyle.blocks.sobel import smooth_and_steep
from vidstyle.core.kernels import compiled


@block(
    "filter",
    on="luma",
    radius=lambda: 1,
    chroma="dropped",
    label="Relief",
    category="texture",
    aliases="emboss, bump, light, 3d, impasto, plaster, canvas, texture, linen, carving",
)
def relief(
    luma: np.ndarray,
    depth: Annotated[
        float, Slider(0, 16, "strength of light and shade", explore=(0.5, 3), label="Relief depth")
    ] = 1,
    angle: Annotated[
        float,
        Slider(
            -180, 180, "direction of the light; 90 for light from above", "degrees", label="Light direction"
        ),
    ] = 135,
) -> np.ndarray:
    """Light the picture like an embossed surface.

    Luma is the height: gray where flat, bright towards the light, dark away from it. Half white plus
    depth times the slope towards the light (3 x 3 Sobel, divided by 8), clipped to black and white. For
    thick paint or rough paper, `blend` it over a picture with the mode grain_merge.
    """
    turn, step = math.radians(angle), depth / 8
    gains = np.float32(-step * math.cos(turn)), np.float32(step * math.sin(turn))
    out = np.empty(luma.shape, np.float32)
    _light(luma, gains, np.empty((2, luma.shape[1] + 2), np.float32), out)
    return out


@compiled
def _light(luma, gains, scratch, out):  # type: ignore[no-untyped-def]
    zero, half, one, two = np.float32(0), np.float32(0.5), np.float32(1), np.float32(2)
    (to_right, to_bottom), last = gains, luma.shape[0] - 1
    smooth, steep = scratch[0], scratch[1]
    for row in range(luma.shape[0]):
        smooth_and_steep(luma[max(row - 1, 0)], luma[row], luma[min(row + 1, last)], smooth, steep)
        for x in range(luma.shape[1]):
            across = to_right * (smooth[x + 2] - smooth[x])
            down = to_bottom * (steep[x] + two * steep[x + 1] + steep[x + 2])
            out[row, x] = min(max(across + down + half, zero), one)
