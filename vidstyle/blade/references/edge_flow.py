"""Filters that follow the edges: edge tangent flow and the flow-guided difference of Gaussians.

The direction comes from the smoothed structure tensor, which is interpolated as a tensor: angles of opposite
sign cannot be averaged, tensors can (Kyprianidis and Doellner 2008; Brox et al. 2006).
"""

from __future__ import annotations

import math

import cv2
import numpy as np

from vidstyle.blade.references.rows import for_all_rows, require_positive
from vidstyle.blade.structure_tensor import window_weights
from vidstyle.core.kernels import compiled, index_at
from vidstyle.core.resample import resample, scaled_shape

MAX_GAUSSIAN_DEVIATIONS = 3
"""Standard deviations at which a Gaussian is cut off. At 2 it would lose a twentieth of its weight and an
eighth of its standard deviation, so sigma would be wrong; at 3 it loses a seventieth."""

MIN_EIGENVALUE_DIFFERENCE = 1e-9
"""Minimum difference of the tensor's eigenvalues, relative to its trace; less is rounding error."""

ALONG_ACROSS_RATIO = 1.5
"""Ratio of the standard deviations along and across the flow, at sigma 1 and above."""

WIDE_NARROW_RATIO = 1.6
"""Ratio of the standard deviations of two Gaussians whose difference approximates a Laplacian (Marr and
Hildreth 1980)."""


def edge_tangent_flow(luma: np.ndarray, sigma: float = 2.0, rho: float = 2.0, steps: float = 1) -> np.ndarray:
    """Average luma along its edges.

    Paper, section 5.4.2, equation 12: diffusion along the tangent of the smoothed structure tensor,
    independent of the strength of the gradient, as a line integral convolution with second-order Runge-Kutta
    steps of one pixel.

    Args:
        luma: H x W, 0..1; beyond its border the border is repeated.
        sigma: standard deviation in pixels along the line; diffusion for the time sigma^2 / 2.
        rho: standard deviation in pixels of the tensor's smoothing; larger values give broader strokes.
        steps: number of repetitions, each along the lines of the previous result, as in the paper.

    Returns:
        H x W float32, new, within the range of luma.

    Raises:
        UsageError: a length or the number of steps is not above 0.
    """
    require_positive(sigma=sigma, rho=rho, steps=steps)
    for _ in range(round(steps)):
        planes = luma.astype(np.float64)[..., np.newaxis]
        luma = average_along_lines(planes, structure_tensor(luma, rho), sigma)[..., 0].astype(np.float32)
    return luma


def flow_dog_parts(
    luma: np.ndarray, sigma: float = 1.0, sigma_m: float | None = None, rho: float = 2.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the two parts of the flow-guided high-emphasis filter, smooth + p * difference.

    This filter, Flow-XDoG without its soft threshold, is (1 + p) G_sigma - p G_1.6sigma across the edge, then
    a Gaussian along the flow (Kang et al. 2009; Winnemoeller et al. 2012). The paper (section 5.4.3)
    prints the two Gaussians in reverse order, which would blur. The result far exceeds 0..1.

    All lengths scale with sigma. Above 1, directions are computed on the picture reduced by sigma, as in the
    selection of filters, so that broad lines follow broad shapes and not their grain.

    Args:
        luma: H x W, 0..1; beyond its border the border is repeated.
        sigma: standard deviation in pixels across the edge, of the narrower Gaussian.
        sigma_m: standard deviation in pixels along the flow; None for `ALONG_ACROSS_RATIO` times sigma, or
            times 1 below 1.
        rho: standard deviation of the structure tensor's smoothing, in pixels of the reduced picture.

    Returns:
        G_sigma and G_sigma - G_1.6sigma, both smoothed along the flow; H x W float32, new.

    Raises:
        UsageError: a length is not above 0.
    """
    coarseness = max(sigma, 1.0)
    along = ALONG_ACROSS_RATIO * coarseness if sigma_m is None else sigma_m
    require_positive(sigma=sigma, sigma_m=along, rho=rho)
    reduced = resample(luma, scaled_shape(luma.shape, 1 / coarseness), "smooth")
    tensor = resample(structure_tensor(reduced, rho), luma.shape, "bilinear")
    across = np.empty((*luma.shape, 2))
    plane = luma.astype(np.float64)[..., np.newaxis]

    def run(top: int, bottom: int) -> None:
        _filter_across(top, bottom, plane, tensor, sigma, math.ceil(1 / sigma), np.empty((2, 2)), across)

    for_all_rows(run, luma.shape)
    parts = average_along_lines(across, tensor, along).astype(np.float32)
    return parts[..., 0].copy(), parts[..., 1].copy()


@compiled(fastmath=True)
def _filter_across(top, bottom, luma, tensor, sigma, pace, scratch, out):  # type: ignore[no-untyped-def]
    """Compute G_sigma and its difference from the wider Gaussian on the straight line across the edge.

    The samples are on the grid's columns, or on rows if the line is steep, so that they are interpolated
    between only two pixels and blurred less; `pace` samples per column, more for a narrow Gaussian. Without a
    direction the smooth value is the pixel and the difference is 0.
    """
    samples, sums = scratch[0], scratch[1]
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
            for number in range(1, math.ceil(MAX_GAUSSIAN_DEVIATIONS * WIDE_NARROW_RATIO * sigma / step) + 1):
                distance = number * step
                samples[0] = 0
                add_sample(luma, column + distance * across, row - distance * down, 1.0, samples)
                add_sample(luma, column - distance * across, row + distance * down, 1.0, samples)
                narrow = math.exp(-((distance / sigma) ** 2) / 2)
                wide = math.exp(-((distance / (WIDE_NARROW_RATIO * sigma)) ** 2) / 2)
                sums[0] += narrow * samples[0]
                sums[1] += wide * samples[0]
                totals_narrow += 2 * narrow
                totals_wide += 2 * wide
            out[row, column, 0] = sums[0] / totals_narrow
            out[row, column, 1] = out[row, column, 0] - sums[1] / totals_wide


def structure_tensor(luma: np.ndarray, rho: float) -> np.ndarray:
    """Return the smoothed products of the derivatives: H x W x 3 float64, xx, xy and yy, y pointing down.

    Differences along the diagonals of 2 x 2 pixels, as in the features by which filters are selected (paper,
    section 5.3), in the same window, so that both see the same lines. The differences are between the pixels;
    the Gaussian of standard deviation rho has an even number of taps and recenters them. It is cut off at two
    rho.
    """
    weights = window_weights(rho).astype(np.float64)
    radius = len(weights) // 2
    padded = np.pad(luma.astype(np.float64), radius, mode="edge")
    falling = padded[1:, 1:] - padded[:-1, :-1]
    rising = padded[:-1, 1:] - padded[1:, :-1]
    across, down = (falling + rising) / 2, (falling - rising) / 2
    products = np.stack([across * across, across * down, down * down], axis=-1)
    smooth = cv2.sepFilter2D(products, cv2.CV_64F, weights, weights, anchor=(0, 0))
    return np.ascontiguousarray(smooth[: luma.shape[0], : luma.shape[1]])


def gaussian(offsets: np.ndarray, sigma: float) -> np.ndarray:
    """Return the weights of a Gaussian of standard deviation sigma at these offsets; they add up to 1."""
    weights = np.exp(-(offsets**2) / (2 * sigma**2))
    return weights / weights.sum()


def average_along_lines(planes: np.ndarray, tensor: np.ndarray, sigma: float) -> np.ndarray:
    """Compute a line integral convolution: Gaussian averages over arc length (Cabral and Leedom 1993).

    Args:
        planes: H x W x N float64.
        tensor: from `structure_tensor`.
        sigma: standard deviation of the Gaussian in pixels.

    Returns:
        H x W x N float64, new. Each pixel is an average with positive weights, so there is no overshoot and a
        constant is kept. Pixels where the tensor has no direction stay unchanged, and lines continue straight
        across them. In the faint noise of flat areas directions are random; the average along any line is
        weaker noise.
    """
    step = min(1.0, sigma)
    weights = gaussian(step * np.arange(math.ceil(MAX_GAUSSIAN_DEVIATIONS * sigma / step) + 1), sigma)
    out = np.empty(planes.shape)
    for_all_rows(_average_along_lines, planes.shape[:2], planes, tensor, weights, step, out)
    return out


@compiled(fastmath=True)
def _average_along_lines(top, bottom, planes, tensor, weights, step, out):  # type: ignore[no-untyped-def]
    for row in range(top, bottom):
        for column in range(planes.shape[1]):
            start_x, start_y = tangent_at(tensor, float(column), float(row))
            for plane in range(planes.shape[2]):
                out[row, column, plane] = weights[0] * planes[row, column, plane]
            total = weights[0]
            for side in (-1.0, 1.0):
                x, y = float(column), float(row)
                along_x, along_y = side * start_x, side * start_y
                for weight in weights[1:]:
                    along_x, along_y = _midpoint_direction(tensor, x, y, along_x, along_y, step)
                    x, y = x + step * along_x, y + step * along_y
                    add_sample(planes, x, y, weight, out[row, column])
                    total += weight
            for plane in range(planes.shape[2]):
                out[row, column, plane] /= total


@compiled(fastmath=True)
def _midpoint_direction(tensor, x, y, along_x, along_y, step):  # type: ignore[no-untyped-def]
    """Return the direction half a step ahead: second-order Runge-Kutta."""
    half_x, half_y = _turn_with(tangent_at(tensor, x, y), along_x, along_y)
    middle = tangent_at(tensor, x + step / 2 * half_x, y + step / 2 * half_y)
    return _turn_with(middle, half_x, half_y)


@compiled(fastmath=True)
def _turn_with(tangent, along_x, along_y):  # type: ignore[no-untyped-def]
    """Choose the sign of the tangent that continues the line; without a tangent continue straight."""
    x, y = tangent
    if x == 0 and y == 0:
        return along_x, along_y
    return (x, y) if x * along_x + y * along_y >= 0 else (-x, -y)


@compiled(fastmath=True)
def tangent_at(tensor, x, y):  # type: ignore[no-untyped-def]
    """Return the unit eigenvector of the smaller eigenvalue at a point between pixels, or 0, 0."""
    left, right, upper, lower, u, v = _neighbours(tensor.shape[1], tensor.shape[0], x, y)
    a, b, c, d = (1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v
    p, q, r, s = tensor[upper, left], tensor[upper, right], tensor[lower, left], tensor[lower, right]
    xx = a * p[0] + b * q[0] + c * r[0] + d * s[0]
    xy = a * p[1] + b * q[1] + c * r[1] + d * s[1]
    yy = a * p[2] + b * q[2] + c * r[2] + d * s[2]
    difference = (xx - yy) / 2
    spread = np.sqrt(difference * difference + xy * xy)
    if spread <= MIN_EIGENVALUE_DIFFERENCE * (xx + yy):
        return 0.0, 0.0
    # Of the two formulas for the gradient's direction, use the one that adds numbers of the same sign.
    across, down = (difference + spread, xy) if difference >= 0 else (xy, spread - difference)
    length = np.sqrt(across * across + down * down)
    return -down / length, across / length


@compiled(fastmath=True)
def add_sample(planes, x, y, weight, total):  # type: ignore[no-untyped-def]
    """Add the weighted values at a point between pixels, interpolated bilinearly, to a total of N numbers."""
    left, right, upper, lower, u, v = _neighbours(planes.shape[1], planes.shape[0], x, y)
    for plane in range(planes.shape[2]):
        above = (1 - u) * planes[upper, left, plane] + u * planes[upper, right, plane]
        below = (1 - u) * planes[lower, left, plane] + u * planes[lower, right, plane]
        total[plane] += weight * ((1 - v) * above + v * below)


@compiled(fastmath=True)
def _neighbours(width, height, x, y):  # type: ignore[no-untyped-def]
    """Return the columns and rows around a point, and its position between them; the border is repeated."""
    x, y = min(max(x, 0.0), width - 1.0), min(max(y, 0.0), height - 1.0)
    left, upper = index_at(x, width - 1), index_at(y, height - 1)
    return left, min(left + 1, width - 1), upper, min(upper + 1, height - 1), x - left, y - upper
