"""One use of a network: working size, tiles, and the way back to the size of the picture."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np

from vidstyle.errors import StyleError
from vidstyle.network.network_process import StyleNetwork

RANGES = {"0..255": (0.0, 255.0), "0..1": (0.0, 1.0), "-1..1": (-1.0, 1.0)}
"""The numbers that networks use for black and white."""
MAX_TILE_PX = 1024
"""Maximum side of the part of a picture that a network gets at once."""
OVERLAP_PX = 64
"""Width of the common part of two tiles, in which one fades into the other."""
MIN_WEIGHT = 1e-3
"""Weight of the ends of a tile, which counts at the edges of a picture only."""
SIZE_MULTIPLE = 32
"""Sides of tiles are multiples of this, as most networks halve a picture several times."""
GUIDE_RADIUS_PX = 4
"""Radius of the square in which the detail of picture and result is compared, at the working size."""
MIN_GUIDE_VARIANCE = 1e-3
"""Variance of the picture up to which its detail counts as noise."""


@dataclass(frozen=True)
class NetworkRun:
    """A network with its settings.

    Attributes:
        network: the network.
        scale: its numbers for black and white.
        side: shorter side of the pictures that it gets, in pixels; smaller pictures keep their size.
        amount: weight of the result, 0..1; the rest is the picture.
    """

    network: StyleNetwork
    scale: tuple[float, float]
    side: int
    amount: float

    def run(self, picture: np.ndarray, out: np.ndarray) -> None:
        """Write the result for a picture, H x W x 3 float32 0..1, to `out`.

        Raises:
            StyleError: the network fails.
        """
        black, white = self.scale
        layout = self.network.layout

        def stylize(tile: np.ndarray) -> np.ndarray:
            result = self.network.run(tile * np.float32(white - black) + np.float32(black))
            return (result - np.float32(black)) / np.float32(white - black)

        small = _reduced(np.clip(picture, 0, 1), self.side)
        try:
            result = in_tiles(small, stylize, (layout.height, layout.width))
        except ValueError as error:
            raise StyleError("network", [f"the model {error}"]) from None
        np.clip(result, 0, 1, out=result)
        enlarge(result, small, picture, out)
        if self.amount < 1:
            out *= np.float32(self.amount)
            out += np.float32(1 - self.amount) * picture


def in_tiles(
    picture: np.ndarray, function: Callable[[np.ndarray], np.ndarray], fixed: tuple[int, int]
) -> np.ndarray:
    """Return the result of a function that is called for overlapping tiles of a picture.

    Args:
        picture: H x W x 3 float32.
        function: maps a tile to another of the same size.
        fixed: height and width of tiles; 0: any, up to `MAX_TILE_PX`.
    """
    height, width = picture.shape[:2]
    (rows, high), (columns, wide) = map(_tile_places, (height, width), fixed)
    room = (0, max(0, high - height)), (0, max(0, wide - width)), (0, 0)
    whole = np.pad(picture, room, mode="symmetric")
    total, weights = np.zeros_like(whole), np.zeros((*whole.shape[:2], 1), np.float32)
    weight = (_ramp(high)[:, None] * _ramp(wide))[..., None]
    for top in rows:
        for left in columns:
            area = slice(top, top + high), slice(left, left + wide)
            total[area] += weight * function(np.ascontiguousarray(whole[area]))
            weights[area] += weight
    return np.asarray((total / weights)[:height, :width])


def enlarge(result: np.ndarray, small: np.ndarray, picture: np.ndarray, out: np.ndarray) -> None:
    """Write a result at the size of a picture to `out`, with the fine detail that the picture has.

    Detail is weighted by the slope of the result over the picture around each pixel, as in a guided filter
    (He and Sun 2015, "Fast guided filter"); the result itself stays unchanged.

    Args:
        result: the result for `small`, the picture at the working size.
    """
    if result.shape == picture.shape:
        out[:] = result
        return
    size, side = picture.shape[1::-1], 2 * GUIDE_RADIUS_PX + 1

    def mean(plane: np.ndarray) -> np.ndarray:
        return cv2.blur(plane, (side, side), borderType=cv2.BORDER_REPLICATE)

    for channel in range(3):
        guide, made, fine = (np.ascontiguousarray(each[..., channel]) for each in (small, result, picture))
        variance = mean(guide * guide) - mean(guide) ** 2
        covariance = mean(guide * made) - mean(guide) * mean(made)
        slope = np.clip(covariance / (variance + np.float32(MIN_GUIDE_VARIANCE)), -1, 1)
        fine -= cv2.resize(guide, size, interpolation=cv2.INTER_CUBIC)
        fine *= cv2.resize(slope, size, interpolation=cv2.INTER_LINEAR)
        fine += cv2.resize(made, size, interpolation=cv2.INTER_CUBIC)
        np.clip(fine, 0, 1, out=out[..., channel])


def _reduced(picture: np.ndarray, side: int) -> np.ndarray:
    factor = side / min(picture.shape[:2])
    if factor >= 1:
        return picture
    size = [max(1, round(each * factor)) for each in picture.shape[1::-1]]
    return cv2.resize(picture, size, interpolation=cv2.INTER_AREA)


def _tile_places(length: int, fixed: int) -> tuple[list[int], int]:
    """Return the first rows or columns of the tiles along a side, and their common size."""
    most = fixed or MAX_TILE_PX
    overlap = _overlap(most)
    count = max(1, math.ceil((length - overlap) / (most - overlap)))
    size = fixed or SIZE_MULTIPLE * math.ceil((length + (count - 1) * overlap) / count / SIZE_MULTIPLE)
    last = max(0, length - size)
    return [round(last * number / max(1, count - 1)) for number in range(count)], size


def _ramp(length: int) -> np.ndarray:
    """Return the weights along a side of a tile: next to nothing at its ends, where a network sees little."""
    place, overlap = np.arange(length, dtype=np.float32), _overlap(length)
    inside = np.minimum(place, place[::-1]) - overlap // 4
    return np.clip(inside / np.float32(max(1, overlap // 2)), np.float32(MIN_WEIGHT), 1)


def _overlap(size: int) -> int:
    return min(OVERLAP_PX, size // 4)
