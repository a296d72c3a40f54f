"""Gaussian smoothing."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated

import cv2
import numpy as np

from vidstyle.block import Margin, ResultRows, Slider, block
from vidstyle.core.kernels import compiled, interleaved

UNROLLED_TAP_COUNT = 3
"""Pairs of taps that one iteration of the inner loop adds."""
VECTOR_SIZE = 16
"""Numbers in a vector."""
TILE_SIZE = 512
"""Numbers of a row that form a tile: its rows stay in the first-level cache."""


def _radius(sigma: float) -> int:
    return math.ceil(3 * sigma)


@block(
    "filter",
    on="channels",
    radius=_radius,
    label="Blur",
    category="smooth",
    aliases=(
        "soften, soft, smooth, soft focus, out of focus, depth of field, denoise, noise reduction, glow, "
        "bloom, tilt shift, dreamy, misty, fog, bokeh"
    ),
)
def gaussian(
    picture: np.ndarray,
    margin: Margin,
    out: ResultRows,
    sigma: Annotated[
        float,
        Slider(
            0,
            50,
            "more for a softer picture: standard deviation",
            "px",
            explore=(0.5, 4),
            label="Blur",
            max_detail=1,
        ),
    ] = 2,
) -> np.ndarray:
    """Blur the picture: noise and small detail disappear.

    The kernel is cut off at three sigma; edge pixels are repeated beyond the border. Paper, section 4.2 B.
    """
    if sigma == 0:
        return picture
    weights, channels = _weights(sigma), picture.size // (picture.shape[0] * picture.shape[1])
    line = np.empty(TILE_SIZE + 2 * channels * weights.size + 2 * VECTOR_SIZE, np.float32)
    _blur(interleaved(picture), weights, channels, margin, line, interleaved(out))
    return out


@lru_cache(maxsize=64)
def _weights(sigma: float) -> np.ndarray:
    """Return the weights from the middle outwards, padded by zeros to a multiple of `UNROLLED_TAP_COUNT`."""
    radius = _radius(sigma)
    half = cv2.getGaussianKernel(2 * radius + 1, sigma, cv2.CV_32F)[radius:, 0]
    return np.pad(half, (0, -radius % UNROLLED_TAP_COUNT))


@compiled(fastmath=True, noalias=True)
def _blur(picture, weights, channels, margin, line, out):  # type: ignore[no-untyped-def]
    """Blur vertically, then horizontally, in tiles whose rows stay in the first-level cache.

    Args:
        line: scratch, a row of a tile with the columns that are read on both sides of it.
    """
    (height, width), beside = picture.shape, channels * (weights.size - 1)
    whole = -(-beside // VECTOR_SIZE) * VECTOR_SIZE
    line = line[-(line.ctypes.data // 4) % VECTOR_SIZE :]  # accesses that cross cache lines are slower
    for begin in range(0, width, TILE_SIZE):
        end = min(begin + TILE_SIZE, width)
        first, last = max(begin - whole, 0), min(end + beside, width)
        before, behind = whole - (begin - first), beside - (last - end)
        own = line[before : before + last - first]
        for row in range(margin[0], height - margin[1]):
            _add_rows(picture, row, first, weights, own)
            for x in range(before):
                line[before - 1 - x] = line[before - 1 - x + channels]
            beyond = before + own.size
            for x in range(behind):
                line[beyond + x] = line[beyond + x - channels]
            _add_places(line[whole - beside :], beside, channels, weights, out[row - margin[0], begin:end])


@compiled(fastmath=True, noalias=True)
def _add_rows(picture, row, first, weights, out):  # type: ignore[no-untyped-def]
    last = picture.shape[0] - 1
    middle = picture[row][first:]
    for x in range(out.size):
        out[x] = weights[0] * middle[x]
    for tap in range(1, weights.size, UNROLLED_TAP_COUNT):
        a, b, c = weights[tap], weights[tap + 1], weights[tap + 2]
        above, below = picture[max(row - tap, 0)][first:], picture[min(row + tap, last)][first:]
        above2, below2 = picture[max(row - tap - 1, 0)][first:], picture[min(row + tap + 1, last)][first:]
        above3, below3 = picture[max(row - tap - 2, 0)][first:], picture[min(row + tap + 2, last)][first:]
        for x in range(out.size):
            near, far = a * (above[x] + below[x]), c * (above3[x] + below3[x])
            out[x] += near + b * (above2[x] + below2[x]) + far


@compiled(fastmath=True, noalias=True)
def _add_places(line, beside, step, weights, out):  # type: ignore[no-untyped-def]
    middle = line[beside:]
    for x in range(out.size):
        out[x] = weights[0] * middle[x]
    for tap in range(1, weights.size, UNROLLED_TAP_COUNT):
        a, b, c = weights[tap], weights[tap + 1], weights[tap + 2]
        left, right = line[beside - step * tap :], line[beside + step * tap :]
        left2, right2 = line[beside - step * (tap + 1) :], line[beside + step * (tap + 1) :]
        left3, right3 = line[beside - step * (tap + 2) :], line[beside + step * (tap + 2) :]
        for x in range(out.size):
            near, far = a * (left[x] + right[x]), c * (left3[x] + right3[x])
            out[x] += near + b * (left2[x] + right2[x]) + far
