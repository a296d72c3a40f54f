"""Detail control: edge-aware smoothing, whose residual is the detail.

Talebi and Milanfar 2016: W z + (W2 z - W z) + ... + (z - Wk z) with ever finer kernels, each layer of detail
times its factor. Their kernels are elementwise powers of one another: squaring a kernel divides its contrast
by the root of 2. A block combines the bases W z that are computed here.
"""

from __future__ import annotations

import numpy as np

from vidstyle.blade.references.edge_flow import gaussian
from vidstyle.blade.references.rows import for_all_rows, require_positive
from vidstyle.core.kernels import compiled

WINDOW_RADIUS_PX = 4
"""Pixels on each side that the base is averaged from: windows of 9 x 9."""


def detail_base(luma: np.ndarray, contrast: float = 40.0, spread: float = 2.5) -> np.ndarray:
    """Remove detail from luma: average nearby pixels with similar neighbourhoods.

    The non-local means kernel of Talebi and Milanfar 2016 (Buades et al. 2005) over 9 x 9 pixels,
    comparing squares of 3 x 3, which also flattens speckles that a bilateral filter leaves. Normalized by the
    sum of its weights; their form without a division can overshoot where many pixels are similar.

    Args:
        luma: H x W, 0..1; beyond its border the border is repeated.
        contrast: levels of 255 that count as detail: this root mean square difference between two squares
            gives a weight of exp(-1/2).
        spread: standard deviation in pixels of the weight by distance.

    Returns:
        H x W float32, new, within the range of luma: each pixel is an average with positive weights.

    Raises:
        UsageError: contrast or spread is not above 0.
    """
    require_positive(contrast=contrast, spread=spread)
    weights = gaussian(np.arange(-WINDOW_RADIUS_PX, WINDOW_RADIUS_PX + 1), spread).astype(np.float32)
    falloff = np.float32(1 / (2 * 9 * (contrast / 255) ** 2))
    padded = np.pad(luma.astype(np.float32), WINDOW_RADIUS_PX + 1, mode="edge")
    out = np.empty(luma.shape, np.float32)

    def run(top: int, bottom: int) -> None:
        scratch = np.empty(luma.shape[1] + 2, np.float32), np.empty(luma.shape[1], np.float32)
        _average_alike(top, bottom, padded, weights, falloff, scratch, out)

    for_all_rows(run, luma.shape)
    return out


@compiled(fastmath=True)
def _average_alike(top, bottom, padded, weights, falloff, scratch, out):  # type: ignore[no-untyped-def]
    """Compare the picture with its shifted copies, row by row and shift by shift."""
    width, size = out.shape[1], weights.shape[0]
    squares, totals = scratch
    for row in range(top, bottom):
        for x in range(width):
            out[row, x], totals[x] = 0, 0
        for down in range(size):
            for across in range(size):
                _compare_columns(padded[row + size // 2 :], padded[row + down :], size // 2, across, squares)
                nearby, near = padded[row + down + 1, across + 1 :], weights[down] * weights[across]
                for x in range(width):
                    unlike = squares[x] + squares[x + 1] + squares[x + 2]
                    weight = near * np.exp(-falloff * unlike)
                    out[row, x] += weight * nearby[x]
                    totals[x] += weight
        for x in range(width):
            out[row, x] /= totals[x]


@compiled(fastmath=True)
def _compare_columns(rows, shifted, start, shifted_start, squares):  # type: ignore[no-untyped-def]
    """Sum the squared differences of three rows for each column."""
    for x in range(squares.shape[0]):
        upper = rows[0, start + x] - shifted[0, shifted_start + x]
        middle = rows[1, start + x] - shifted[1, shifted_start + x]
        lower = rows[2, start + x] - shifted[2, shifted_start + x]
        squares[x] = upper * upper + middle * middle + lower * lower
