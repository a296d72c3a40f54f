"""Flow-guided difference of Gaussians: sharpening across the edges, smoothing along them."""

from __future__ import annotations

import math

import numpy as np

from vidstyle.blade.references.line_integral import (
    CUT,
    add_sample,
    average_along_lines,
    structure_tensor,
    tangent_at,
)
from vidstyle.blade.references.rows import for_all_rows, require_positive
from vidstyle.core.kernels import compiled

WIDER = 1.6
"""Ratio of the two Gaussians, whose difference approximates a Laplacian (Marr and Hildreth 1980)."""


def flow_dog_parts(
    luma: np.ndarray, sigma: float = 1.0, sigma_m: float = 2.0, rho: float = 2.0
) -> tuple[np.ndarray, np.ndarray]:
    """The two pictures of which the flow-guided high-emphasis filter is smooth + p * difference.

    That filter, Flow-XDoG before its soft threshold, is (1 + p) G_sigma - p G_1.6sigma across the edge, then
    a Gaussian along the flow (Kang and others 2009; Winnemoeller and others 2012). The paper (section 5.4.3)
    prints the two Gaussians the other way round, which would blur. It goes far beyond 0..1.

    Args:
        luma: H x W, 0..1; beyond its border the border is repeated.
        sigma: standard deviation in pixels across the edge, of the narrower Gaussian.
        sigma_m: standard deviation in pixels along the flow.
        rho: standard deviation in pixels of the structure tensor's smoothing.

    Returns:
        G_sigma and G_sigma - G_1.6sigma, both smoothed along the flow; H x W float32, new.

    Raises:
        UsageError: a length is not above 0.
    """
    require_positive(sigma=sigma, sigma_m=sigma_m, rho=rho)
    tensor = structure_tensor(luma, rho)
    across = np.empty((*luma.shape, 2))
    plane = luma.astype(np.float64)[..., np.newaxis]
    for_all_rows(_filter_across, luma.shape[0], plane, tensor, sigma, math.ceil(1 / sigma), across)
    parts = average_along_lines(across, tensor, sigma_m).astype(np.float32)
    return parts[..., 0].copy(), parts[..., 1].copy()


@compiled(fastmath=True)
def _filter_across(top, bottom, luma, tensor, sigma, pace, out):  # type: ignore[no-untyped-def]
    """G_sigma and its difference from the wider one on the straight line across the edge.

    The samples lie on the grid's columns, or rows where the line is steep, so that they are interpolated
    between two pixels only and blurred less; `pace` of them to a column, more for a narrow Gaussian.
    Without a direction the pixel is its own smooth value and there is no difference.
    """
    samples, sums = np.empty(1), np.empty(2)
    for row in range(top, bottom):
        for column in range(luma.shape[1]):
            down, across = tangent_at(tensor, float(column), float(row))
            out[row, column, 0], out[row, column, 1] = luma[row, column, 0], 0
            steepest = max(abs(across), abs(down))
            if steepest == 0:
                continue
            step = 1 / (pace * steepest)
            totals_narrow = totals_wide = 1.0
            sums[0] = sums[1] = luma[row, column, 0]
            for number in range(1, math.ceil(CUT * WIDER * sigma / step) + 1):
                distance = number * step
                samples[0] = 0
                add_sample(luma, column + distance * across, row - distance * down, 1.0, samples)
                add_sample(luma, column - distance * across, row + distance * down, 1.0, samples)
                narrow = math.exp(-((distance / sigma) ** 2) / 2)
                wide = math.exp(-((distance / (WIDER * sigma)) ** 2) / 2)
                sums[0] += narrow * samples[0]
                sums[1] += wide * samples[0]
                totals_narrow += 2 * narrow
                totals_wide += 2 * wide
            out[row, column, 0] = sums[0] / totals_narrow
            out[row, column, 1] = out[row, column, 0] - sums[1] / totals_wide
