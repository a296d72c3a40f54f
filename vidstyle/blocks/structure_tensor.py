"""Structure tensor: the direction of edges, as a picture."""

from __future__ import annotations

import numpy as np

from vidstyle.block import LumaWeights, Margin, ResultRows, block
from vidstyle.blocks.sobel import smooth_and_steep
from vidstyle.core.kernels import compiled, interleaved


@block(
    "filter",
    on="color",
    radius=lambda: 1,
    exact=True,
    label="Edge direction",
    category="parts",
    aliases="flow field, orientation, structure tensor",
)
def structure_tensor(
    picture: np.ndarray, weights: LumaWeights, margin: Margin, out: ResultRows
) -> np.ndarray:
    """Measure the direction of edges, for blocks that follow them.

    Direction and strength are encoded as colours, for `kuwahara` and others; smooth them with `gaussian`.
    With s the square root of the luma gradient's magnitude (3 x 3 Sobel, divided by 4, clipped at 1) and
    t its direction, red is (1 + s cos 2t) / 2, green (1 + s sin 2t) / 2 and blue s. Doubled angles can be
    averaged, and opposite gradients have the same direction. Smoothed, the result is the structure tensor
    of the paper's section 5.3, equations 6 to 8, weighted by s instead of the squared magnitude, so that
    the strongest edge nearby does not dominate all others.
    """
    scratch = np.empty((5, picture.shape[1] + 2), np.float32)
    _encode(interleaved(picture), weights, margin, scratch, interleaved(out))
    return out


@compiled
def _luma_of_row(row, weights, luma):  # type: ignore[no-untyped-def]
    red, green, blue = weights[0], weights[1], weights[2]
    for x in range(luma.size):
        luma[x] = red * row[3 * x] + green * row[3 * x + 1] + blue * row[3 * x + 2]


@compiled
def _encode(picture, weights, margin, scratch, out):  # type: ignore[no-untyped-def]
    height, width = picture.shape[0], picture.shape[1] // 3
    half, one, two, least = np.float32(0.5), np.float32(1), np.float32(2), np.float32(1e-20)
    smooth, steep, rows = scratch[0], scratch[1], scratch[2:, :width]
    for row in range(margin[0] - 2, height - margin[1]):
        _luma_of_row(picture[min(max(row + 1, 0), height - 1)], weights, rows[(row + 1) % 3])
        if row < margin[0]:
            continue
        smooth_and_steep(rows[(row - 1) % 3], rows[row % 3], rows[(row + 1) % 3], smooth, steep)
        own = out[row - margin[0]]
        for x in range(width):
            across = np.float32(0.25) * (smooth[x + 2] - smooth[x])
            down = np.float32(0.25) * (steep[x] + two * steep[x + 1] + steep[x + 2])
            # (x^2 - y^2, 2 x y) has the squared length and twice the angle.
            squared = across * across + down * down
            strength = np.sqrt(min(np.sqrt(squared), one))
            each = half * strength / max(squared, least)
            own[3 * x] = half + each * (across * across - down * down)
            own[3 * x + 1] = half + each * two * across * down
            own[3 * x + 2] = strength
