"""Sobel filter: edges."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Margin, ResultRows, Slider, Switch, block
from vidstyle.core.kernels import compiled


@block(
    "filter",
    on="luma",
    radius=lambda: 1,
    chroma="dropped",
    label="Edge detection",
    category="lines",
    aliases="edges, find edges, outline, outlines, contour, neon, glow, gradient, borders",
)
def sobel(
    luma: np.ndarray,
    margin: Margin,
    out: ResultRows,
    gain: Annotated[
        float,
        Slider(0, 16, "more to show fainter edges too", explore=(1, 4), power=1, label="Edge strength"),
    ] = 2,
    invert: Annotated[
        bool, Switch("dark lines on white, as in the lines layer", label="Dark lines on white")
    ] = False,
) -> np.ndarray:
    """Show where edges are: bright lines on black.

    The magnitude of the luma gradient, as a gray picture. 3 x 3 Sobel, divided by 4 and clipped at white;
    edge pixels are repeated beyond the border. Paper, section 4.2 B.
    """
    scratch = np.empty((2, luma.shape[1] + 2), np.float32)
    _edges(luma, np.float32(gain / 4), invert, margin[0], scratch, out)
    return out


@compiled
def _edges(luma, gain, invert, first, scratch, out):  # type: ignore[no-untyped-def]
    one, two, last = np.float32(1), np.float32(2), luma.shape[0] - 1
    smooth, steep = scratch[0], scratch[1]
    for row in range(out.shape[0]):
        y = first + row
        smooth_and_steep(luma[max(y - 1, 0)], luma[y], luma[min(y + 1, last)], smooth, steep)
        for x in range(out.shape[1]):
            across = smooth[x + 2] - smooth[x]
            down = steep[x] + two * steep[x + 1] + steep[x + 2]
            edge = min(gain * np.sqrt(across * across + down * down), one)
            out[row, x] = one - edge if invert else edge


@compiled
def smooth_and_steep(above, middle, below, smooth, steep):  # type: ignore[no-untyped-def]
    """Apply the vertical halves of a 3 x 3 Sobel filter: smooth a row, and compute its downward slope.

    Args:
        above, middle, below: three rows of W numbers.
        smooth, steep: W + 2 numbers, written; the first and last repeat the ends of the row.
    """
    width = middle.size
    for x in range(width):
        smooth[x + 1] = above[x] + np.float32(2) * middle[x] + below[x]
        steep[x + 1] = below[x] - above[x]
    smooth[0], steep[0] = smooth[1], steep[1]
    smooth[width + 1], steep[width + 1] = smooth[width], steep[width]
