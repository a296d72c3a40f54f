"""The local mode: the most frequent tone around each pixel, on which filters named oil painting are based."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from vidstyle.block import Margin, ResultRows, Slider, block
from vidstyle.core.kernels import compiled, index_at

LEVEL_COUNT = 32
"""Tones of a histogram; between two of them a pixel counts for both."""
SHARE_STEPS = 256
"""Steps of the share of a pixel that counts for the brighter of two tones."""
WHITE_CODE = 16383
"""White in the sums of tones: for 17 x 17 pixels, they fit in 31 bits."""
MAX_MODE_RADIUS = 8
"""Maximum number of pixels on each side of the window."""
MAX_EXPONENT = 8
"""Maximum exponent of the histogram."""


@block("filter", on="luma", radius=lambda radius: radius)
def local_mode(
    luma: np.ndarray,
    margin: Margin,
    out: ResultRows,
    radius: Annotated[int, Slider(1, MAX_MODE_RADIUS, "pixels on each side of the square window", "px")] = 4,
    exponent: Annotated[
        int, Slider(1, MAX_EXPONENT, "1 for the mean, higher ones for the most frequent tone")
    ] = 4,
    amount: Annotated[float, Slider(0, 1, "0 for no effect")] = 1,
) -> np.ndarray:
    """Replace luma by the most frequent tone of a square around each pixel.

    The result is the mean of the square's pixels, weighted by a power of the histogram at their tone:
    h ^ (exponent - 1). The histogram has 32 tones from black to white, with linear interpolation. Pixels
    beyond the border repeat the border. Luma is clipped to 0..1. As "oilify" of GIMP, whose tones are not
    interpolated; columns of histograms as in Perreault and Hébert 2007, "Median Filtering in Constant Time".
    """
    columns = np.zeros((luma.shape[1] + 2 * radius, 2, LEVEL_COUNT), np.int32)
    window, values = np.zeros((2, LEVEL_COUNT), np.int32), (radius, exponent, np.float32(amount))
    _filter(luma, margin[0], values, columns, window, out)
    return out


@compiled(fastmath=True)
def _filter(luma, first, values, columns, window, out):  # type: ignore[no-untyped-def]
    """Slide a window over the histograms of columns.

    Args:
        columns: scratch, zeros: counts and sums of tones of each column of the window.
        window: scratch for the counts and sums of the window.
    """
    (radius, exponent, amount), last = values, luma.shape[0] - 1
    for row in range(-radius, radius):
        _count(luma[min(max(first + row, 0), last)], radius, 1, columns)
    for row in range(out.shape[0]):
        _count(luma[min(max(first + row + radius, 0), last)], radius, 1, columns)
        window[:] = 0
        for x in range(2 * radius):
            _add(columns[x], 1, window)
        for x in range(out.shape[1]):
            _add(columns[x + 2 * radius], 1, window)
            mode, own = _weighted_mean(window, exponent), luma[first + row, x]
            out[row, x] = own + amount * (mode - own)
            _add(columns[x], -1, window)
        _count(luma[min(max(first + row - radius, 0), last)], radius, -1, columns)


@compiled
def _count(line, radius, sign, columns):  # type: ignore[no-untyped-def]
    """Add a row of luma to the histograms of the columns, or with the sign -1 subtract it."""
    for x in range(columns.shape[0]):
        tone = min(max(line[min(max(x - radius, 0), line.size - 1)], np.float32(0)), np.float32(1))
        place = tone * np.float32(LEVEL_COUNT - 1)
        level = index_at(place, LEVEL_COUNT - 2)
        upper = np.int32((place - np.float32(level)) * np.float32(SHARE_STEPS) + np.float32(0.5))
        code = np.int32(tone * np.float32(WHITE_CODE) + np.float32(0.5))
        upper, lower = np.int32(sign * upper), np.int32(sign * (SHARE_STEPS - upper))
        columns[x, 0, level] += lower
        columns[x, 0, level + 1] += upper
        columns[x, 1, level] += lower * code
        columns[x, 1, level + 1] += upper * code


@compiled
def _add(column, sign, window):  # type: ignore[no-untyped-def]
    for level in range(LEVEL_COUNT):
        window[0, level] += np.int32(sign) * column[0, level]
        window[1, level] += np.int32(sign) * column[1, level]


@compiled(fastmath=True)
def _weighted_mean(window, exponent):  # type: ignore[no-untyped-def]
    """Return the mean of the tones, weighted by a power of their counts."""
    total, count = np.float32(0), np.float32(0)
    for level in range(LEVEL_COUNT):
        share = np.float32(window[0, level]) * np.float32(1 / (SHARE_STEPS * 289))
        weight = np.float32(1)
        for _ in range(exponent - 1):
            weight *= share
        total += weight * np.float32(window[1, level])
        count += weight * np.float32(window[0, level])
    return total / (count * np.float32(WHITE_CODE))
