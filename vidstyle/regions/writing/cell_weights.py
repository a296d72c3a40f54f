"""Weights of writing in cells of a picture, from measures of its strokes.

Foliage, gravel and cloth have thin strokes too, but there a wider closing adds more everywhere, little ground
is left unchanged, and the rest has thin bright parts.
"""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.kernels import aligned_empty, compiled
from vidstyle.regions.writing.cell_means import (
    BRIGHT,
    CELL_PX,
    EVEN,
    ISLANDS,
    OTHERS,
    PEAKS,
    SQUARES,
    STROKES,
    average_measures,
)
from vidstyle.regions.writing.morphology import average_floats, filter_squares, greater
from vidstyle.regions.writing.stroke_measures import StrokeMeasures

STRENGTH_RANGE = 20.0, 34.0
"""Contrast of strokes, in 8-bit levels, from which they count, and from which they count fully."""
GROUND_RANGE = 0.45, 0.5
"""Share of even ground, in the same way."""
BRIGHT_RANGE = 0.2, 0.1
"""Thin bright parts of the ground relative to the strokes, in the same way: the less, the better."""
COHERENCE_RANGE = 0.95, 0.8
"""How much strokes have one direction, in the same way: letters have several, edges and wires one; 0..1."""
AGREEMENT_RANGE = 0.2, 0.45
"""Share of strokes nearby that fulfil this, in the same way."""
WEIGHT_RANGE = 0.25, 0.75
"""Product of all these, in the same way."""
WINDOW_RATIO, AGREEMENT_WINDOW_RATIO = 4, 9
"""Windows of these shares, relative to the thickness."""
WORD_RATIO, SIDE_DIFFERENCE = 13, 0.04
"""Side of the window of a word, in the same way, in which strokes are dark or light; and the difference of
mean weights from which they are either. Below it, both are left to the style."""
MIN_GROUND_WEIGHT = 0.1
"""The least weight of the outline of a bright word."""
REST_CONTRAST_RANGE = 0.5, 0.75
"""Contrast of the rest of the picture relative to the whole, in the same way: on bare paper, a stretch of
contrast would show the rest alone."""
TONE_QUANTILES = 0.005, 0.995
"""Quantiles of luma that count as the darkest and the brightest tone."""
REACH_RATIO = 3
"""Distance from writing within which every stroke counts, relative to the thickness: ends of words."""

_RANGES = tuple(
    (np.float32(first), np.float32(second))
    for first, second in (
        STRENGTH_RANGE,
        GROUND_RANGE,
        BRIGHT_RANGE,
        COHERENCE_RANGE,
        AGREEMENT_RANGE,
        WEIGHT_RANGE,
        REST_CONTRAST_RANGE,
    )
)


def weigh_cells(luma: np.ndarray, measures: StrokeMeasures, thickness: int) -> np.ndarray:
    """Return the weight of dark and of light strokes in each cell, 2 x h x w float32, 0..1; 0 in a dry run.

    Args:
        luma: H x W uint8, of at least a cell.
        measures: of its strokes.
        thickness: of its strokes.
    """
    ratios = WINDOW_RATIO, AGREEMENT_WINDOW_RATIO, REACH_RATIO, WORD_RATIO
    near, around, reach, word = (_cells(ratio * thickness) for ratio in ratios)
    height, width = (max(1, round(side / CELL_PX)) for side in luma.shape)
    sums = np.empty((height + 1, width)), np.empty(width + max(near, around, reach, word))
    means, nearby, slopes = average_measures(measures, (height, width), near, sums)
    padded = np.empty((2, height + 2 * reach, width + reach), np.float32)
    weights = np.zeros((2, height, width), np.float32)
    _weigh(
        luma,
        # Rounding of OpenCV's square root depends on the address of the result.
        (means, nearby, cv2.magnitude(slopes[0], slopes[1], aligned_empty((height, width, 2)))),
        (around, reach, word),
        _RANGES,
        (np.float32(MIN_GROUND_WEIGHT), np.float32(SIDE_DIFFERENCE)),
        TONE_QUANTILES,
        (sums, padded, padded.reshape(2, -1), np.empty((3, height, width), np.float32)),
        np.empty((2, 256), np.int64),
        weights,
    )
    return weights


def _cells(length: float) -> int:
    """Return a length in pixels of the copy as an odd number of cells."""
    return max(1, 2 * round((length / CELL_PX - 1) / 2) + 1)


@compiled
def _weigh(  # type: ignore[no-untyped-def]
    luma, fields, windows, ranges, limits, quantiles, scratch, counts, weights
):
    (means, nearby, lengths), (around, reach, word) = fields, windows
    sums, padded, flat, grounds = scratch
    for side in range(2):
        ground, spare, out = grounds[side], grounds[2], weights[side]
        _weigh_strokes(means[side], nearby[side], lengths[..., side], ranges, out)
        _weigh_agreement(means[side, STROKES], around, ranges[4], sums, (ground, spare), out)
        _extend(out, reach, ranges[5], sums, padded, flat)
        _find_ground(nearby[side, ISLANDS], nearby[side, PEAKS], limits[0], ground)
    _keep_one_side(grounds, word, limits[1], sums, weights)
    _weigh_rest(luma, quantiles, ranges[6], counts, weights)


@compiled
def _ramp(value, ends):  # type: ignore[no-untyped-def]
    """A smooth ramp from 0 at the first of `ends` to 1 at the second, float32."""
    share = (value - ends[0]) / (ends[1] - ends[0])
    share = min(max(share, np.float32(0)), np.float32(1))
    return share * share * (np.float32(3) - np.float32(2) * share)


@compiled
def _weigh_strokes(means, nearby, lengths, ranges, out):  # type: ignore[no-untyped-def]
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            weight = _ramp(means[PEAKS, y, x], ranges[0])
            weight *= _ramp(nearby[EVEN, y, x] / np.float32(255), ranges[1])
            ink = nearby[STROKES, y, x] + np.float32(0.25)
            weight *= _ramp(nearby[BRIGHT, y, x] / ink, ranges[2])
            squares = nearby[SQUARES, y, x] + nearby[OTHERS, y, x]
            out[y, x] = weight * _ramp(lengths[y, x] / (squares + np.float32(1e-3)), ranges[3])


@compiled
def _weigh_agreement(strokes, around, ends, sums, scratch, out):  # type: ignore[no-untyped-def]
    """Weigh cells by the share of strokes nearby that have weights."""
    weighted, total = scratch
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            weighted[y, x] = strokes[y, x] * out[y, x]
    average_floats(weighted, around, sums, weighted)
    average_floats(strokes, around, sums, total)
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            out[y, x] *= _ramp(weighted[y, x] / (total[y, x] + np.float32(0.25)), ends)


@compiled
def _extend(weights, reach, ends, sums, padded, flat):  # type: ignore[no-untyped-def]
    """Give the weight of a cell to all cells within `reach` of it, with smooth borders."""
    (height, width), pitch = weights.shape, padded.shape[2]
    for y in range(height):
        for x in range(width):
            padded[0, reach + y, x] = weights[y, x]
    filter_squares(greater, 0, flat[0], 2 * reach - 1, (pitch, reach), flat[1], flat[0])
    for y in range(height):
        for x in range(width):
            weights[y, x] = padded[0, reach + y, x]
    average_floats(weights, reach, sums, weights)
    for y in range(height):
        for x in range(width):
            weights[y, x] = _ramp(weights[y, x], ends)


@compiled
def _find_ground(islands, peaks, least, out):  # type: ignore[no-untyped-def]
    """Find how far the ground continues, which is low if it is only as large as a word."""
    for y in range(out.shape[0]):
        for x in range(out.shape[1]):
            share = islands[y, x] / (peaks[y, x] + np.float32(1))
            out[y, x] = max(np.float32(1) - share, least)


@compiled
def _keep_one_side(grounds, word, difference, sums, weights):  # type: ignore[no-untyped-def]
    """Keep dark or light strokes in each word.

    Between light letters the ground looks like dark strokes, and the other way round.
    """
    dark, light, side = weights[0], weights[1], grounds[2]
    for y in range(dark.shape[0]):
        for x in range(dark.shape[1]):
            side[y, x] = dark[y, x] * grounds[0, y, x] - light[y, x] * grounds[1, y, x]
    average_floats(side, word, sums, side)
    unit = np.float32(0), np.float32(1)
    for y in range(dark.shape[0]):
        for x in range(dark.shape[1]):
            weight, share = max(dark[y, x], light[y, x]), side[y, x] / difference
            dark[y, x], light[y, x] = weight * _ramp(share, unit), weight * _ramp(-share, unit)


@compiled
def _weigh_rest(luma, quantiles, ends, counts, weights):  # type: ignore[no-untyped-def]
    """Weigh by the contrast of the picture without the parts with weights, relative to that of all of it."""
    (height, width), dark, light = luma.shape, weights[0], weights[1]
    counts[:] = 0
    for y in range(dark.shape[0]):
        row = min(int(y * (height / dark.shape[0])), height - 1)
        for x in range(dark.shape[1]):
            level = luma[row, min(int(x * (width / dark.shape[1])), width - 1)]
            counts[0, level] += 1
            counts[1, level] += dark[y, x] == 0 and light[y, x] == 0
    whole, rest = _contrast(counts[0], quantiles), _contrast(counts[1], quantiles)
    factor = _ramp(np.float32(rest / whole), ends)
    for y in range(dark.shape[0]):
        for x in range(dark.shape[1]):
            dark[y, x], light[y, x] = dark[y, x] * factor, light[y, x] * factor


@compiled
def _contrast(counts, quantiles):  # type: ignore[no-untyped-def]
    """The range of levels between two quantiles, and 1; 0 without levels."""
    total = counts.sum()
    if total == 0:
        return 0.0
    return _quantile(counts, quantiles[1], total) - _quantile(counts, quantiles[0], total) + 1


@compiled
def _quantile(counts, share, total):  # type: ignore[no-untyped-def]
    place = share * (total - 1)
    below = int(place)
    low, high = _level_at(counts, below), _level_at(counts, min(below + 1, total - 1))
    return low + (place - below) * (high - low)


@compiled
def _level_at(counts, place):  # type: ignore[no-untyped-def]
    level, passed = 0, counts[0]
    while passed <= place:
        level += 1
        passed += counts[level]
    return float(level)
