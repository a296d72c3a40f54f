"""Pen: bright ridges as thin lines of one width."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Margin, ResultRows, Slider, block
from vidstyle.core.kernels import compiled

MIN_CURVATURE = np.float32(1e-6)
"""Smallest divisor, where the picture is even or black."""


@block(
    "filter",
    on="luma",
    radius=lambda: 1,
    chroma="dropped",
    label="Pen lines",
    category="lines",
    aliases="technical pen, fineliner, line weight, thin lines, line art, outline, skeleton, neon tube, wire",
)
def pen(
    luma: np.ndarray,
    margin: Margin,
    out: ResultRows,
    width: Annotated[
        float,
        Slider(0.5, 12, "width of a strong line", "px", explore=(1, 4), label="Line width", max_detail=1.5),
    ] = 2,
    threshold: Annotated[
        float,
        Slider(0, 255, "lower for more lines, including faint ones", "of 255", label="Faintest line"),
    ] = 90,
) -> np.ndarray:
    """Draw the crests of bright ridges as black lines on white, all of one width.

    The picture, which should be smooth, shows edges as bright ridges: `contour` or `sobel`, blurred. Across
    the direction of its strongest negative curvature -c, a ridge with slope g has its crest at the
    distance t = g / (c + g^2 / luma), as if its profile were Gaussian, and about the height h = luma +
    g^2 / 2c; lines are where t is within half the width. The width grows with h from half the threshold to
    one and a half, and is less on flat ridges, with c below h / (4 width)^2. Edges are anti-aliased. Steger
    1998, "An unbiased detector of curvilinear structures", on 3 x 3 pixels.
    """
    limits = np.float32(width), np.float32(threshold / 510), np.float32(255 / max(threshold, 1))
    _draw(luma, limits, margin[0], out)
    return out


@compiled(noalias=True)
def _draw(luma, limits, first, out):  # type: ignore[no-untyped-def]
    (width, least, steepness), last, end = limits, luma.shape[0] - 1, luma.shape[1] - 1
    for row in range(out.shape[0]):
        y = first + row
        above, own, below = luma[max(y - 1, 0)], luma[y], luma[min(y + 1, last)]
        drawn = out[row]
        for x in range(drawn.size):
            left, right = max(x - 1, 0), min(x + 1, end)
            drawn[x] = np.float32(1) - _cover(above, own, below, left, x, right, width, least, steepness)


@compiled
def _cover(above, own, below, left, x, right, width, least, steepness):  # type: ignore[no-untyped-def]
    """Return how much of a pixel a line covers."""
    zero, half, one, two, three = np.float32(0), np.float32(0.5), np.float32(1), np.float32(2), np.float32(3)
    across, down = half * (own[right] - own[left]), half * (below[x] - above[x])
    bent_across = own[right] - two * own[x] + own[left]
    bent_down = below[x] - two * own[x] + above[x]
    twist = np.float32(0.25) * (below[right] + above[left] - above[right] - below[left])
    stretch = half * (bent_across - bent_down)
    size = max(np.sqrt(stretch * stretch + twist * twist), MIN_CURVATURE)
    curvature = max(size - half * (bent_across + bent_down), MIN_CURVATURE)
    steep = across * across * (size - stretch) + down * down * (size + stretch) - two * across * down * twist
    steep = half * max(steep, zero) / size
    height = own[x] + half * steep / curvature
    strength = min(max((height - least) * steepness, zero), one)
    sharpness = min(np.float32(16) * width * width * curvature / max(height, MIN_CURVATURE), one)
    drawn = sharpness * width * strength * strength * (three - two * strength)
    distance = np.sqrt(steep) / (curvature + steep / max(own[x], MIN_CURVATURE))
    return min(max(half * drawn + half - distance, zero), min(drawn, one))
