"""Defects of single frames: broken blocks and test pictures."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np

# Damage: decoders repeat the last good rows downwards.
_SMEAR_HEIGHT_PX, _MIN_SMEAR_LEVELS = 12, 6.0
"""Height of a smear, and minimum mean difference between neighbouring pixels of its rows, of 255."""
_MAX_SMEARED_SHARE = 0.03
"""A picture is damaged if a larger share of it is smeared."""


# Damage that the decoder does not report: blocks that do not continue their neighbours.
_BLOCK_SIDE_PX, _AREA_SIDE_COUNT = 8, 6
"""Side of a block, and side in blocks of the areas in which broken edges are counted."""
_MIN_EDGE_LEVELS, _MIN_EDGE_SHARE = 8, 0.74
"""A block edge is broken if it exceeds the steps next to it by these levels on this share of its length."""
_BOTH_FACTOR = 4
"""Broken edges of both directions count at most this multiple of the rarer direction."""

# Corners of broken blocks, which remain if a damaged film was scaled and encoded again.
_CORNER_BLUR_DEVIATION_PX = 0.6
"""Standard deviation of the Gaussian under which straight edges are found."""
_MIN_STRAIGHT_LEVELS, _MIN_STRAIGHT_LENGTH_PX = 12, 6
"""Minimum step across a straight edge, of 255, and its minimum length."""
_MAX_ALONG_RATIO, _MIN_THIN_RATIO = (3, 20), (8, 5)
"""Maximum step along a straight edge, relative to the step across it, and minimum step across it, relative to
both sides of it; numerators and denominators."""
_CORNER_REACH_PX = 5
"""Side of the square in which edges of both directions form a corner."""

# Test pictures: vertical bars without texture, or large areas in most of the primary colours.
_BAR_HEIGHT_SHARE = 0.5
"""The share of the height that bars fill at least; other signals may be below them."""
_MIN_BAR_STEP_LEVELS, _MIN_BAR_STEPS = 12, 3
"""Minimum step between bars, and minimum number of steps."""
_MAX_BAR_NOISE_LEVELS, _MAX_BAR_NOISE_SHARE = 6, 0.01
"""Noise within a bar, and the share of pixels that may exceed it."""
_PRIMARY_LOW_LEVEL, _PRIMARY_HIGH_LEVEL = 50, 170
"""Each channel of a primary colour is below the first or above the second value, also in bars of 75 %."""
_PRIMARY_BITS = np.array(
    [0 if level < _PRIMARY_LOW_LEVEL else 1 if level > _PRIMARY_HIGH_LEVEL else 8 for level in range(256)],
    np.uint8,
)
"""Low and high levels of a channel as a bit, other levels as 8."""
_MIN_PRIMARIES, _MIN_PRIMARY_SHARE = 5, 0.03
"""Number of primary colours, and minimum share of the picture that each of them covers."""


class Blockiness(NamedTuple):
    """The largest share of broken block edges in any area of a frame.

    Attributes:
        on_grid: on the codec's grid, beyond those off the grid.
        off_grid: off the grid, beyond those on the grid: textures have as many.
    """

    on_grid: float = 0.0
    off_grid: float = 0.0


def measure_blockiness(luma: np.ndarray) -> Blockiness:
    """Measure the broken edges of blocks in a frame as it is stored, H x W uint8."""
    if min(luma.shape) < 2 * _BLOCK_SIDE_PX * _AREA_SIDE_COUNT:
        return Blockiness()
    across, down = _count_broken_edges(luma), _count_broken_edges(luma.T).T
    rows, columns = min(len(across), len(down)), min(across.shape[1], down.shape[1])
    size = _AREA_SIDE_COUNT, _AREA_SIDE_COUNT
    areas = [cv2.blur(each[:rows, :columns], size, borderType=cv2.BORDER_CONSTANT) for each in (across, down)]
    return Blockiness(_largest_in_both(*areas), _largest_in_both(*(-each for each in areas)))


def _largest_in_both(one: np.ndarray, other: np.ndarray) -> float:
    """Return the largest sum of two shares that are both present: stripes break edges of one direction."""
    both = np.minimum(one + other, _BOTH_FACTOR * np.minimum(one, other))
    return max(0.0, float(both.max()))


def _count_broken_edges(luma: np.ndarray) -> np.ndarray:
    """Return for each block whether its vertical edge is broken: 1, -1 half a block beside it, float32."""
    side = _BLOCK_SIDE_PX
    on_grid, off_grid = (_find_broken_edges(luma, first) for first in (side - 2, side // 2 - 2))
    return on_grid.astype(np.float32) - off_grid


def _find_broken_edges(luma: np.ndarray, first: int) -> np.ndarray:
    """Return whether each block has a broken vertical edge after the second column from `first` on."""
    side, rows = _BLOCK_SIDE_PX, len(luma) // _BLOCK_SIDE_PX * _BLOCK_SIDE_PX
    count = len(range(side - 2, luma.shape[1] - 3, side))
    left, before, after, right = (
        np.ascontiguousarray(luma[:rows, first + number :: side][:, :count]) for number in range(4)
    )
    beside = cv2.max(cv2.absdiff(left, before), cv2.absdiff(after, right))
    broken = cv2.subtract(cv2.absdiff(before, after), beside) > _MIN_EDGE_LEVELS
    return broken.reshape(rows // side, side, count).mean(axis=1) >= _MIN_EDGE_SHARE


def count_block_corners(luma: np.ndarray) -> int:
    """Count the places where straight edges along both axes meet, H x W uint8.

    The edges are as hard as the edges of blocks, at any place: the grid of a scaled film is not known.
    """
    smooth = cv2.GaussianBlur(luma, (0, 0), _CORNER_BLUR_DEVIATION_PX).astype(np.int16)
    across, down = (np.abs(each) for each in _central_steps(smooth))
    upright = _straight_edges(across, down)
    level = _straight_edges(np.ascontiguousarray(down.T), np.ascontiguousarray(across.T)).T
    reach = np.ones((_CORNER_REACH_PX, _CORNER_REACH_PX), np.uint8)
    both = cv2.min(cv2.dilate(upright, reach), cv2.dilate(np.ascontiguousarray(level), reach))
    return int(cv2.connectedComponents(both)[0]) - 1


def _central_steps(smooth: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the differences of the pixels on both sides, across and down; 0 at the edges."""
    across, down = np.zeros_like(smooth), np.zeros_like(smooth)
    across[:, 1:-1] = smooth[:, 2:] - smooth[:, :-2]
    down[1:-1] = smooth[2:] - smooth[:-2]
    return across, down


def _straight_edges(across: np.ndarray, along: np.ndarray) -> np.ndarray:
    """Return the mask of upright edges that are thin and long, H x W uint8, 0 or 1."""
    beside = np.zeros_like(across)
    beside[:, 2:] = across[:, :-2]
    beside[:, :-2] = np.maximum(beside[:, :-2], across[:, 2:])
    (part, whole), (more, less) = _MAX_ALONG_RATIO, _MIN_THIN_RATIO
    # In integers, as factors with a fraction would make arrays of float64.
    found = (
        (across > _MIN_STRAIGHT_LEVELS) & (whole * along < part * across) & (less * across > more * beside)
    )
    return cv2.morphologyEx(
        found.astype(np.uint8), cv2.MORPH_OPEN, np.ones((_MIN_STRAIGHT_LENGTH_PX, 1), np.uint8)
    )


def is_smeared(luma: np.ndarray) -> bool:
    """Whether rows of the picture, H x W uint8, are repeated downwards, as in incompletely decoded frames."""
    if min(luma.shape) <= 2 * _SMEAR_HEIGHT_PX:
        return False
    steps = cv2.blur(cv2.absdiff(luma[1:, 1:], luma[1:, :-1]), (9, 1))
    down = cv2.dilate(cv2.absdiff(luma[1:, 1:], luma[:-1, 1:]), np.ones((_SMEAR_HEIGHT_PX, 3), np.uint8))
    return bool(np.mean((down <= 1) & (steps >= _MIN_SMEAR_LEVELS)) > _MAX_SMEARED_SHARE)


def is_test_picture(color: np.ndarray) -> bool:
    """Whether a picture, H x W x 3 uint8, shows the bars or colours of a test picture."""
    return _has_bars(cv2.cvtColor(color, cv2.COLOR_RGB2GRAY)) or _has_primaries(color)


def _has_bars(luma: np.ndarray) -> bool:
    upper = luma[: max(1, round(_BAR_HEIGHT_SHARE * len(luma)))].astype(np.float32)
    columns = upper.mean(axis=0)
    noise = np.mean(np.abs(upper - columns) > _MAX_BAR_NOISE_LEVELS)
    steps = int((np.abs(np.diff(columns)) > _MIN_BAR_STEP_LEVELS).sum())
    return bool(noise < _MAX_BAR_NOISE_SHARE and steps >= _MIN_BAR_STEPS)


def _has_primaries(color: np.ndarray) -> bool:
    # A bit of each channel; pixels with a channel between the levels get codes from 8 on.
    codes = cv2.transform(cv2.LUT(color, _PRIMARY_BITS), np.array([[1, 2, 4]], np.float32))
    shares = np.bincount(codes.ravel(), minlength=8)[1:7] / codes.size
    return int((shares > _MIN_PRIMARY_SHARE).sum()) >= _MIN_PRIMARIES
