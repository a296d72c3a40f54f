"""Finds writing: thin strokes of one polarity on even ground, such as letters, signs and wires.

`stroke_measures` finds thin strokes, and `cell_weights` tells writing from foliage, gravel and cloth.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import cv2
import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.writing.cell_means import CELL_PX
from vidstyle.regions.writing.cell_weights import weigh_cells
from vidstyle.regions.writing.stroke_measures import measure_strokes

MAX_SEARCHED_SIDE_PX = 360
"""Shorter side of the copy that is searched, at most."""
THICKNESS_RATIO = 9 / 720
"""Width of strokes that count as thin, relative to the picture's shorter side."""
MIN_WEIGHT = 1 / 255
"""Weights up to this count as 0."""

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
    thickness = thickness_of(small.shape)
    weights = weigh_cells(small, measure_strokes(small, thickness), thickness)
    return [_writing(weights, box, picture) for box in _boxes(weights)]


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


def _odd(length: float) -> int:
    """Return the odd number at or above a length, at least 3."""
    return max(3, 2 * math.floor(length / 2) + 1)
