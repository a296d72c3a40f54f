"""Contour: faint and strong edges alike, of brightness and of colour."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from vidstyle.block import LumaWeights, Margin, SavedRef, Slider, block
from vidstyle.core.kernels import compiled, gray_rgb, interleaved

MIN_SQUARE = np.float32(1e-12)
"""Smallest divisor, for a threshold of 0 where the picture is even."""


@block(
    "filter",
    on="color",
    radius=lambda: 1,
    label="Faint edges",
    category="parts",
    aliases="silhouette, pale on pale, white on white, dark on dark, borders",
)
def contour(
    picture: np.ndarray,
    weights: LumaWeights,
    margin: Margin,
    clutter: Annotated[
        Any,
        SavedRef("blurred edges, which tell how many there are", on="luma", label="Amount of detail from"),
    ] = "source",
    threshold: Annotated[
        float,
        Slider(
            0,
            64,
            "lower for more lines, including faint edges; higher for fewer",
            "of 255",
            label="Faintest edge",
        ),
    ] = 6,
    sparsity: Annotated[
        float,
        Slider(0, 8, "higher for fewer lines where there is much detail", label="Sparsity"),
    ] = 1.35,
) -> np.ndarray:
    """Find edges, including faint ones, as a gray picture; where there is much detail, only strong edges.

    With e the gradient (3 x 3 Sobel, divided by 4; the root of its mean square over the channels, weighted
    as in luma), n the threshold and c the luma of `clutter` times the sparsity, the result is
    e^2 / (e^2 + n^2 + c^2). `flow_xdog` makes thin lines of its negative.
    """
    out = np.empty(picture.shape[:2], np.float32)
    limits = np.float32((threshold / 255) ** 2), np.float32(sparsity)
    scratch = np.empty((3, 3 * picture.shape[1] + 6), np.float32)
    _stand_out(interleaved(picture), clutter, weights, margin, limits, scratch, out)
    return gray_rgb(out)


@compiled(noalias=True)
def _stand_out(picture, clutter, weights, margin, limits, scratch, out):  # type: ignore[no-untyped-def]
    """Write all rows except the rows of the margin.

    Args:
        scratch: 3 x (3 W + 6).
    """
    (least, sparsity), last = limits, picture.shape[0] - 1
    red, green, blue = weights[0], weights[1], weights[2]
    smooth, steep, squares = scratch[0], scratch[1], scratch[2]
    for row in range(margin[0], last + 1 - margin[1]):
        above, own, below = picture[max(row - 1, 0)], picture[row], picture[min(row + 1, last)]
        _square_gradients(above, own, below, smooth, steep, squares)
        around, drawn = clutter[row], out[row]
        for x in range(drawn.size):
            squared = red * squares[3 * x] + green * squares[3 * x + 1] + blue * squares[3 * x + 2]
            crowd = sparsity * around[x]
            drawn[x] = squared / max(squared + least + crowd * crowd, MIN_SQUARE)


@compiled(noalias=True)
def _square_gradients(above, own, below, smooth, steep, out):  # type: ignore[no-untyped-def]
    """Square the gradients of an interleaved row, whose first and last pixels are repeated beyond it."""
    size, two, scale = own.size, np.float32(2), np.float32(0.0625)
    for i in range(size):
        smooth[i + 3] = above[i] + two * own[i] + below[i]
        steep[i + 3] = below[i] - above[i]
    for i in range(3):
        smooth[i], steep[i] = smooth[i + 3], steep[i + 3]
        smooth[size + 3 + i], steep[size + 3 + i] = smooth[size + i], steep[size + i]
    for i in range(size):
        across = smooth[i + 6] - smooth[i]
        down = steep[i] + two * steep[i + 3] + steep[i + 6]
        out[i] = scale * (across * across + down * down)
