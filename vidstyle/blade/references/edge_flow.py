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

CUT = 3
"""Standard deviations at which a Gaussian ends. At 2 it would lose a twentieth of its weight and an eighth of
its standard deviation, so that a sigma would not mean what it says; at 3 it loses a seventieth."""

ISOTROPIC = 1e-9
"""Share of the tensor's trace by which its eigenvalues must differ; less is rounding."""

ALONG = 1.5
"""Standard deviation along the flow by that across it, at sigma 1 and above."""

WIDER = 1.6
"""Ratio of the two Gaussians, whose difference approximates a Laplacian (Marr and Hildreth 1980)."""


def edge_tangent_flow(luma: np.ndarray, sigma: float = 2.0, rho: float = 2.0, steps: float = 1) -> np.ndarray:
    """Luma averaged along its edges.

    Paper, section 5.4.2, equation 12: diffusion along the tangent of the smoothed structure tensor, whatever
    the strength of the gradient, as a line integral convolution with second-order Runge-Kutta steps of one
    pixel.

    Args:
        luma: H x W, 0..1; beyond its border the border is repeated.
        sigma: standard deviation in pixels along the line; diffusion for the time sigma^2 / 2.
        rho: standard deviation in pixels of the tensor's smoothing; larger ones give broader strokes.
        steps: how often, each time along the lines of what the step before has made, as in the paper.

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
    """The two pictures of which the flow-guided high-emphasis filter is smooth + p * difference.

    That filter, Flow-XDoG before its soft threshold, is (1 + p) G_sigma - p G_1.6sigma across the edge, then
    a Gaussian along the flow (Kang et al. 2009; Winnemoeller et al. 2012). The paper (section 5.4.3)
    prints the two Gaussians the other way round, which would blur. It goes far beyond 0..1.

    All lengths grow with sigma: directions are those of the picture reduced by sigma, where sigma is above 1,
    which is what the choice of filters sees too. Broad lines follow broad shapes, not the grain on them.

    Args:
        luma: H x W, 0..1; beyond its border the border is repeated.
        sigma: standard deviation in pixels across the edge, of the narrower Gaussian.
        sigma_m: standard deviation in pixels along the flow; None for `ALONG` sigma, or `ALONG` below 1.
        rho: standard deviation of the structure tensor's smoothing, in pixels of the reduced picture.

    Returns:
        G_sigma and G_sigma - G_1.6sigma, both smoothed along the flow; H x W float32, new.

    Raises:
        UsageError: a length is not above 0.
    """
    coarseness = max(sigma, 1.0)
    along = ALONG * coarseness if sigma_m is None else sigma_m
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
    """G_sigma and its difference from the wider one on the straight line across the edge.

    The samples lie on the grid's columns, or rows where the line is steep, so that they are interpolated
    between two pixels only and blurred less; `pace` of them to a column, more for a narrow Gaussian.
    Without a direction the pixel is its own smooth value and there is no difference.
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


def structure_tensor(luma: np.ndarray, rho: float) -> np.ndarray:
    """Products of the derivatives, smoothed: H x W x 3 float64, xx, xy and yy, y pointing down.

    Differences along the diagonals of 2 x 2 pixels, as in the features by which filters are chosen (paper,
    section 5.3), in the same window, so both see the same lines. They lie between the pixels; the Gaussian of
    standard deviation rho has an even number of taps and brings them back. It is cut at two rho.
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
    """Weights of a Gaussian of standard deviation sigma at these offsets; they add up to 1."""
    weights = np.exp(-(offsets**2) / (2 * sigma**2))
    return weights / weights.sum()


def average_along_lines(planes: np.ndarray, tensor: np.ndarray, sigma: float) -> np.ndarray:
    """Line integral convolution: Gaussian averages over arc length (Cabral and Leedom 1993).

    Args:
        planes: H x W x N float64.
        tensor: from `structure_tensor`.
        sigma: standard deviation of the Gaussian in pixels, to both sides.

    Returns:
        H x W x N float64, new. Each pixel is an average with positive weights, so nothing overshoots and a
        constant stays. Where the tensor has no direction the pixel stays as it is, and a line that gets there
        goes straight on. In the faint noise of flat places directions are random; the average along any line
        is weaker noise.
    """
    step = min(1.0, sigma)
    weights = gaussian(step * np.arange(math.ceil(CUT * sigma / step) + 1), sigma)
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
    """The direction half a step ahead: second-order Runge-Kutta."""
    half_x, half_y = _turned_with(tangent_at(tensor, x, y), along_x, along_y)
    middle = tangent_at(tensor, x + step / 2 * half_x, y + step / 2 * half_y)
    return _turned_with(middle, half_x, half_y)


@compiled(fastmath=True)
def _turned_with(tangent, along_x, along_y):  # type: ignore[no-untyped-def]
    """A tangent has no sign; give it the one that goes on along the line. Without one go straight on."""
    x, y = tangent
    if x == 0 and y == 0:
        return along_x, along_y
    return (x, y) if x * along_x + y * along_y >= 0 else (-x, -y)


@compiled(fastmath=True)
def tangent_at(tensor, x, y):  # type: ignore[no-untyped-def]
    """The unit eigenvector of the smaller eigenvalue at a place between pixels; 0, 0 where there is none."""
    left, right, upper, lower, u, v = _neighbours(tensor.shape[1], tensor.shape[0], x, y)
    a, b, c, d = (1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v
    p, q, r, s = tensor[upper, left], tensor[upper, right], tensor[lower, left], tensor[lower, right]
    xx = a * p[0] + b * q[0] + c * r[0] + d * s[0]
    xy = a * p[1] + b * q[1] + c * r[1] + d * s[1]
    yy = a * p[2] + b * q[2] + c * r[2] + d * s[2]
    difference = (xx - yy) / 2
    spread = np.sqrt(difference * difference + xy * xy)
    if spread <= ISOTROPIC * (xx + yy):
        return 0.0, 0.0
    # Of the two formulas for the gradient's direction, that which adds numbers of the same sign.
    across, down = (difference + spread, xy) if difference >= 0 else (xy, spread - difference)
    length = np.sqrt(across * across + down * down)
    return -down / length, across / length


@compiled(fastmath=True)
def add_sample(planes, x, y, weight, total):  # type: ignore[no-untyped-def]
    """Add the weighted values at a place between pixels, interpolated bilinearly, to a total of N numbers."""
    left, right, upper, lower, u, v = _neighbours(planes.shape[1], planes.shape[0], x, y)
    for plane in range(planes.shape[2]):
        above = (1 - u) * planes[upper, left, plane] + u * planes[upper, right, plane]
        below = (1 - u) * planes[lower, left, plane] + u * planes[lower, right, plane]
        total[plane] += weight * ((1 - v) * above + v * below)


@compiled(fastmath=True)
def _neighbours(width, height, x, y):  # type: ignore[no-untyped-def]
    """The columns and rows around a place, and how far it lies between them; the border is repeated."""
    x, y = min(max(x, 0.0), width - 1.0), min(max(y, 0.0), height - 1.0)
    left, upper = index_at(x, width - 1), index_at(y, height - 1)
    return left, min(left + 1, width - 1), upper, min(upper + 1, height - 1), x - left, y - upper
