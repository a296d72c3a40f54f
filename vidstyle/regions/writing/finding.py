"""Finds writing: thin strokes of one polarity on even ground, such as letters, signs and wires.

A morphological closing fills thin dark strokes, so that what it adds is the strokes. Foliage, gravel and
cloth have them too, but there a wider closing adds more everywhere, little ground is left as it was, and
what is left has thin bright parts. Light strokes are the dark ones of the negative.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.core.sampling import percentiles
from vidstyle.regions.boxes import Box, Rectangle

MAX_SEARCHED_SIDE_PX = 360
"""Shorter side of the copy that is searched, at most."""
THICKNESS_RATIO = 9 / 720
"""Width of strokes that count as thin, relative to the picture's shorter side."""
CELL_PX = 4
"""Pixels of the copy, across and down, with one weight."""
EVEN_LEVEL_RATIO, EVEN_LEVEL = 0.13, 2
"""Ground is even where the wide closing adds less than this, relative to the strokes, and in 8-bit levels."""

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
MIN_WEIGHT = 1 / 255
"""Weights up to this count as 0."""
WINDOW_RATIO, AGREEMENT_WINDOW_RATIO = 4, 9
"""Windows of these shares, relative to the thickness."""
WORD_RATIO, SIDE_DIFFERENCE = 13, 0.04
"""Side of the window of a word, in the same way, in which strokes are dark or light; and the difference of
mean weights from which they are either. Below it, both are left to the style."""
ISLAND_RATIO, MIN_GROUND_WEIGHT = 5, 0.1
"""Height of a bright word in a dark outline, in the same way; and the least weight of its outline."""
REST_CONTRAST_RANGE = 0.5, 0.75
"""Contrast of the rest of the picture relative to the whole, in the same way: on bare paper, a stretch of
contrast would show the rest alone."""
TONE_QUANTILES = 0.005, 0.995
"""Quantiles of luma that count as the darkest and the brightest tone."""
REACH_RATIO = 3
"""Distance from writing within which every stroke counts, relative to the thickness: ends of words."""

MAX_PARTS = 16
"""If there are more parts, they become one."""


class Writing(NamedTuple):
    """A part of a picture with writing.

    Attributes:
        window: the part.
        dark, light: weight of dark and of light strokes at each pixel, H x W float32, 0..1.
    """

    window: Rectangle
    dark: np.ndarray
    light: np.ndarray


def thickness_of(shape: tuple[int, int]) -> int:
    """Return the width of the squares that fill thin strokes in a picture of this shape: odd pixels."""
    return _odd(THICKNESS_RATIO * min(shape))


def find_writing(picture: Picture) -> list[Writing]:
    """Return the parts of a picture with writing, which do not overlap; none in a picture below a cell."""
    small = _small_luma(picture)
    if min(small.shape) < CELL_PX:
        return []
    weights, ground = _sides(cv2.merge((small, cv2.bitwise_not(small))))
    if not weights.any():
        return []
    # Between light letters the ground looks like dark strokes, and the other way round: a word has one side.
    word = _cells(WORD_RATIO * thickness_of(small.shape))
    side = _mean(cv2.subtract(*cv2.split(weights * ground)), word) / SIDE_DIFFERENCE
    weights = cv2.max(*cv2.split(weights)) * np.stack([_ramp(side, (0, 1)), _ramp(-side, (0, 1))])
    weights *= _ramp(_rest_contrast(small, weights), REST_CONTRAST_RANGE)
    return [_writing(weights, box, picture) for box in _boxes(weights)]


def _sides(small: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the weight of dark strokes in each cell, and how far their ground continues.

    Args:
        small: luma and its negative, H x W x 2 uint8: together, as each call has to wait for Python's lock.

    Returns:
        Both h x w x 2 float32, 0..1. The second is low if the ground is only as large as a word.
    """
    thick = thickness_of(small.shape[:2])
    closed = _closed(small, thick)
    strokes = cv2.subtract(closed, small)
    peaks = cv2.blur(cv2.dilate(strokes, _square(thick)), (thick, thick))
    weight = _writing_weights(small, closed, strokes, peaks)
    if not weight.any():
        return weight, weight
    near = _cells(WINDOW_RATIO * thick)
    island = cv2.subtract(closed, cv2.morphologyEx(closed, cv2.MORPH_OPEN, _square(ISLAND_RATIO * thick)))
    islands, tops = (_mean(each, near) for each in _in_cells(island, peaks))
    share = islands / (tops + 1)
    return weight, np.maximum(1 - share, np.float32(MIN_GROUND_WEIGHT))


def _writing_weights(
    small: np.ndarray, closed: np.ndarray, strokes: np.ndarray, peaks: np.ndarray
) -> np.ndarray:
    """Return the weight of dark strokes in each cell, h x w x 2 float32, 0..1; see `_sides`.

    Args:
        small: luma.
        closed: luma without thin dark strokes.
        strokes: their difference.
        peaks: its maximum nearby.
    """
    thick = thickness_of(small.shape[:2])
    wide = _closed(small, _odd(2 * thick))
    bright = cv2.subtract(closed, cv2.morphologyEx(closed, cv2.MORPH_OPEN, _square(thick)))
    limit = cv2.convertScaleAbs(peaks, alpha=EVEN_LEVEL_RATIO, beta=EVEN_LEVEL)
    even = cv2.compare(cv2.subtract(wide, small), limit, cv2.CMP_LT)
    near = _cells(WINDOW_RATIO * thick)
    (total, bright), (even, tops) = _in_cells(strokes, bright), _in_cells(even, peaks)
    ink, rest, ground = (_mean(each, near) for each in (total, bright, even))
    weight = _ramp(tops, STRENGTH_RANGE) * _ramp(ground / 255, GROUND_RANGE)
    weight *= _ramp(rest / (ink + np.float32(0.25)), BRIGHT_RANGE)
    if not weight.any():
        return weight
    weight *= _ramp(_coherence(strokes, weight.shape[1::-1], near), COHERENCE_RANGE)
    around = _cells(AGREEMENT_WINDOW_RATIO * thick)
    agreement = _mean(total * weight, around) / (_mean(total, around) + np.float32(0.25))
    weight *= _ramp(agreement, AGREEMENT_RANGE)
    reach = _cells(REACH_RATIO * thick)
    return _ramp(_mean(cv2.dilate(weight, _square(2 * reach - 1)), reach), WEIGHT_RANGE)


def _coherence(strokes: np.ndarray, cells: tuple[int, int], window: int) -> np.ndarray:
    """Return how much strokes in a window around each cell have one direction, h x w x 2 float32, 0..1."""
    half = cv2.merge([_halved(each) for each in cv2.split(strokes)])
    across, down = (cv2.Sobel(half, cv2.CV_16S, *order) for order in ((1, 0), (0, 1)))
    squares, others, mixed = (
        cv2.resize(product, cells, interpolation=cv2.INTER_AREA).astype(np.float32)
        for product in (
            cv2.multiply(one, other, scale=1 / 256, dtype=cv2.CV_16S)
            for one, other in ((across, across), (down, down), (across, down))
        )
    )
    squares, others, mixed = (_mean(each, window) for each in (squares, others, mixed))
    return cv2.magnitude(squares - others, 2 * mixed) / (squares + others + np.float32(1e-3))


def _rest_contrast(small: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Return the contrast of a picture without the parts with weights, relative to that of all of it."""
    samples = cv2.resize(small, weights.shape[:0:-1], interpolation=cv2.INTER_NEAREST)
    rest = samples[weights.max(axis=0) == 0]
    if not rest.size:
        return np.zeros(1, np.float32)
    (dark, bright), (darkest, brightest) = (
        percentiles(each, [100 * share for share in TONE_QUANTILES]) for each in (rest, samples)
    )
    return np.array([(bright - dark + 1) / (brightest - darkest + 1)], np.float32)


def _boxes(weights: np.ndarray) -> list[Rectangle]:
    """Return the boxes, in cells, of connected parts with weights, each with one cell around."""
    count, _, found, _ = cv2.connectedComponentsWithStats((weights.max(axis=0) > MIN_WEIGHT).astype(np.uint8))
    boxes = list[Rectangle]()
    for left, top, width, height, _ in found[1:].tolist():
        box = Box(left - 1, top - 1, left + width + 1, top + height + 1)
        while near := [each for each in boxes if each.intersection(box).area or count > MAX_PARTS]:
            boxes = [each for each in boxes if each not in near]
            for each in near:
                box = box.union(each)
        boxes.append(box)
    return boxes


def _writing(weights: np.ndarray, box: Rectangle, picture: Picture) -> Writing:
    """Return the part of a picture in a box of cells, with a weight at each pixel."""
    height, width = picture.shape
    across, down = width / weights.shape[2], height / weights.shape[1]
    right, below = picture.encoding.subsampling
    window = Box(
        int(box.left * across // right) * right,
        int(box.top * down // below) * below,
        math.ceil(box.right * across / right) * right,
        math.ceil(box.bottom * down / below) * below,
    ).intersection(Box(0, 0, width, height))
    move = np.array(
        [
            [1 / across, 0, (window.left + 0.5) / across - 0.5],
            [0, 1 / down, (window.top + 0.5) / down - 0.5],
        ]
    )
    flags, edge = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP, cv2.BORDER_REPLICATE
    size = window.width, window.height
    dark, light = (cv2.warpAffine(each, move, size, flags=flags, borderMode=edge) for each in weights)
    return Writing(window, dark, light)


def _small_luma(picture: Picture) -> np.ndarray:
    """Return the luma of a reduced copy, H x W uint8, 255 for white."""
    plane = picture.luma if picture.color is None else picture.color
    assert plane is not None
    scale = min(1.0, MAX_SEARCHED_SIDE_PX / min(picture.shape))
    height, width = (max(1, round(scale * side)) for side in picture.shape)
    small = cv2.resize(plane, (width, height), interpolation=cv2.INTER_AREA)
    if small.ndim == 3:
        small = cv2.transform(small, picture.encoding.weights[None])
    return levels_of(small, picture)


def levels_of(luma: np.ndarray, picture: Picture) -> np.ndarray:
    """Return luma codes of a picture as uint8, 255 for white."""
    black, white = picture.encoding.luma_levels
    if (black, white) == (0, 255):
        return luma
    luma = np.maximum(luma, np.array(black, luma.dtype))
    return cv2.convertScaleAbs(luma, alpha=255 / (white - black), beta=-255 * black / (white - black))


def _in_cells(one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the means of two arrays, H x W x 2 uint8, in each cell, h x w x 2 float32.

    Together, as OpenCV halves pictures of one or four channels ten times as fast as pictures of two.
    """
    height, width = (max(1, round(side / CELL_PX)) for side in one.shape[:2])
    # Both channels at once, as numbers of 16 bits: a call instead of three, in a quarter of the time.
    four = cv2.merge((one.view(np.uint16), other.view(np.uint16))).view(np.uint8)
    both = cv2.resize(_halved(four), (width, height), interpolation=cv2.INTER_AREA)
    cells = [np.empty((height, width, 2), np.uint8) for _ in range(2)]
    cv2.mixChannels([both], cells, [0, 0, 1, 1, 2, 2, 3, 3])
    return cells[0].astype(np.float32), cells[1].astype(np.float32)


def _halved(plane: np.ndarray) -> np.ndarray:
    return cv2.resize(plane, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)


def _closed(plane: np.ndarray, size: int) -> np.ndarray:
    return cv2.morphologyEx(plane, cv2.MORPH_CLOSE, _square(size))


def _square(size: int) -> np.ndarray:
    return np.ones((size, size), np.uint8)


def _mean(plane: np.ndarray, size: int) -> np.ndarray:
    return cv2.blur(plane, (size, size))


def _ramp(values: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """Return a smooth ramp from 0 at the first of `ends` to 1 at the second, float32."""
    first, second = map(np.float32, ends)
    ramp = np.clip((values - first) / (second - first), 0, 1)
    return np.asarray(ramp * ramp * (3 - 2 * ramp), np.float32)


def _odd(length: float) -> int:
    """Return the odd number at or above a length, at least 3."""
    return max(3, 2 * math.floor(length / 2) + 1)


def _cells(length: float) -> int:
    """Return a length in pixels of the copy as an odd number of cells."""
    return max(1, 2 * round((length / CELL_PX - 1) / 2) + 1)
