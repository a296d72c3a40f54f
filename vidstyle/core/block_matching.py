"""Block matching by normalized cross-correlation."""

from __future__ import annotations

import math

import numpy as np

from vidstyle.core.kernels import compiled

BLOCK_SIZE = 16
"""Pixels on a side of a block."""
SEARCH_RADIUS_PX = 10
"""Pixels that a block may move between pictures, in each direction."""

_POSITION_COUNT = 2 * SEARCH_RADIUS_PX + 1
_PADDED_POSITION_COUNT = 32
"""Positions that the kernel computes: full vectors, of which the first `_POSITION_COUNT` are used."""
_REACH_PX = SEARCH_RADIUS_PX + BLOCK_SIZE + _PADDED_POSITION_COUNT
"""Pixels of the surrounded picture beyond its width that the kernel reads."""


def match_blocks(picture: np.ndarray, before: np.ndarray, min_deviation: float) -> tuple[int, float]:
    """Measure how well the blocks in the middle of a picture match another one near their positions.

    Args:
        picture, before: H x W float32; the border of the second is repeated.
        min_deviation: blocks with a smaller standard deviation are ignored. Half of it is the lower limit for
            areas that they match, otherwise noise would match anything.

    Returns:
        The number of blocks, and the mean of their maximum correlation coefficients, 0..1. In a dry run, all
        blocks match.
    """
    (height, width), (tall, wide) = picture.shape, block_shape(picture.shape)
    # The kernel reads this far beyond the last position.
    wider = np.empty((height + 2 * SEARCH_RADIUS_PX + BLOCK_SIZE, width + _REACH_PX), np.float32)
    positions = height - tall + _POSITION_COUNT, width - wide + _POSITION_COUNT
    found = np.array([(height // tall) * (width // wide), 1], np.float64)
    _match(
        picture,
        before,
        float(min_deviation),
        (tall, wide),
        (wider, np.empty((2, width + _REACH_PX)), np.empty(positions, np.float32)),
        np.zeros((BLOCK_SIZE, BLOCK_SIZE), np.float32),
        np.empty(_PADDED_POSITION_COUNT, np.float32),
        found,
    )
    return int(found[0]), float(found[1])


def block_shape(shape: tuple[int, int]) -> tuple[int, int]:
    """Return height and width of the blocks of a picture."""
    return min(BLOCK_SIZE, shape[0]), min(BLOCK_SIZE, shape[1])


@compiled(fastmath=True, noalias=True)
def _match(picture, before, min_deviation, block, scratch, own, line, found):  # type: ignore[no-untyped-def]
    """One call for all steps, as each call gives up the GIL and takes it back."""
    (height, width), (tall, wide), (wider, sums, deviations) = picture.shape, block, scratch
    _surround(before, wider)
    _measure_deviations(wider, tall, wide, min_deviation / 2, sums, deviations)
    count, total = 0, 0.0
    for row in range(height // tall):
        for column in range(width // wide):
            top, left = height % tall // 2 + row * tall, width % wide // 2 + column * wide
            if _normalize(picture[top : top + tall, left : left + wide], min_deviation, own):
                count += 1
                total += _best_correlation(own, top, left, wider, deviations, line)
    found[0], found[1] = count, total / max(count, 1)


@compiled(fastmath=True, noalias=True)
def _surround(picture, wider):  # type: ignore[no-untyped-def]
    """Copy a picture into the middle of a larger one, and repeat its border."""
    height, width = picture.shape
    for y in range(wider.shape[0]):
        row = picture[min(max(y - SEARCH_RADIUS_PX, 0), height - 1)]
        for x in range(wider.shape[1]):
            wider[y, x] = row[min(max(x - SEARCH_RADIUS_PX, 0), width - 1)]


@compiled(fastmath=True, noalias=True)
def _measure_deviations(wider, tall, wide, min_deviation, sums, deviations):  # type: ignore[no-untyped-def]
    """Compute the standard deviations of areas of `tall` x `wide` pixels by moving sums.

    Args:
        sums: sums and sums of squares of a column, 2 x W float64; overwritten.
        deviations: of the areas that begin at each pixel; at least `min_deviation`.
    """
    sums[:] = 0
    for y in range(tall - 1):
        _add_row(wider[y], 1.0, sums)
    for top in range(deviations.shape[0]):
        _add_row(wider[top + tall - 1], 1.0, sums)
        total, squares = 0.0, 0.0
        for x in range(wide - 1):
            total, squares = total + sums[0, x], squares + sums[1, x]
        for left in range(deviations.shape[1]):
            total, squares = total + sums[0, left + wide - 1], squares + sums[1, left + wide - 1]
            mean = total / (tall * wide)
            variance = squares / (tall * wide) - mean * mean
            deviations[top, left] = math.sqrt(max(variance, min_deviation * min_deviation))
            total, squares = total - sums[0, left], squares - sums[1, left]
        _add_row(wider[top], -1.0, sums)


@compiled(fastmath=True, noalias=True)
def _add_row(row, sign, sums):  # type: ignore[no-untyped-def]
    for x in range(row.size):
        value = float(row[x])
        sums[0, x] += sign * value
        sums[1, x] += sign * value * value


@compiled(fastmath=True, noalias=True)
def _normalize(block, min_deviation, own):  # type: ignore[no-untyped-def]
    """Scale a block so that the sum of its products with an area is the covariance for a deviation of 1.

    Returns:
        Whether its standard deviation is above `min_deviation`; otherwise it is not scaled.
    """
    tall, wide = block.shape
    total = squares = 0.0
    for y in range(tall):
        for x in range(wide):
            total += float(block[y, x])
    mean = total / (tall * wide)
    for y in range(tall):
        for x in range(wide):
            squares += (block[y, x] - mean) ** 2
    deviation = math.sqrt(squares / (tall * wide))
    if deviation <= min_deviation:
        return False
    for y in range(tall):
        for x in range(wide):
            own[y, x] = (block[y, x] - mean) / (tall * wide * deviation)
    return True


@compiled(fastmath=True, noalias=True)
def _best_correlation(own, top, left, wider, deviations, line):  # type: ignore[no-untyped-def]
    most = np.float32(0)
    for row in range(top, top + _POSITION_COUNT):
        line[:] = 0
        for y in range(BLOCK_SIZE):
            _add_products(own[y], wider[row + y, left : left + BLOCK_SIZE + _PADDED_POSITION_COUNT], line)
        for place in range(_POSITION_COUNT):
            most = max(most, line[place] / deviations[row, left + place])
    return most


@compiled(fastmath=True, noalias=True)
def _add_products(own, others, line):  # type: ignore[no-untyped-def]
    """Four columns at once: each sum is loaded and stored a quarter as often."""
    for x in range(0, BLOCK_SIZE, 4):
        first, second, third, fourth = own[x], own[x + 1], own[x + 2], own[x + 3]
        beside = others[x:]
        for place in range(_PADDED_POSITION_COUNT):
            line[place] += (
                first * beside[place]
                + second * beside[place + 1]
                + third * beside[place + 2]
                + fourth * beside[place + 3]
            )
