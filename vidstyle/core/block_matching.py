"""Block matching by normalized cross-correlation."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.kernels import compiled

BLOCK_SIZE = 16
"""Pixels on a side of a block."""
SEARCH_RADIUS_PX = 10
"""Pixels that a block may move between pictures, in each direction."""

_POSITION_COUNT = 2 * SEARCH_RADIUS_PX + 1
_PADDED_POSITION_COUNT = 32
"""Positions that the kernel computes: full vectors, of which the first `_POSITION_COUNT` are used."""


def blocks_of(picture: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the adjacent blocks in the middle of a picture.

    Args:
        picture: H x W.

    Returns:
        n x h x w, at most `BLOCK_SIZE` on a side, and n x 2 int32, the row and column of their first pixels.
    """
    tall, wide = (min(BLOCK_SIZE, side) for side in picture.shape)
    (rows, top), (columns, left) = divmod(picture.shape[0], tall), divmod(picture.shape[1], wide)
    inner = picture[top // 2 :, left // 2 :][: rows * tall, : columns * wide]
    blocks = inner.reshape(rows, tall, columns, wide).swapaxes(1, 2).reshape(-1, tall, wide)
    tops, lefts = np.indices((rows, columns), np.int32).reshape(2, -1)
    return blocks, np.stack([top // 2 + tall * tops, left // 2 + wide * lefts], axis=1)


def best_correlations(
    blocks: np.ndarray, places: np.ndarray, picture: np.ndarray, min_deviation: float
) -> np.ndarray:
    """Measure how well each block matches a picture near its position.

    Args:
        blocks: n x h x w float32, at most `BLOCK_SIZE` on a side; no block has only one tone.
        places: n x 2 int32, the row and column of their first pixels.
        picture: H x W float32; its border is repeated.
        min_deviation: lower limit of the standard deviation of a matched area.

    Returns:
        The maximum correlation coefficient of each block, 0..1 float32; 1 in a dry run.
    """
    (tall, wide), side = blocks.shape[1:], SEARCH_RADIUS_PX
    beyond = side + BLOCK_SIZE, side + _PADDED_POSITION_COUNT  # the kernel reads so far
    wider = cv2.copyMakeBorder(picture, side, beyond[0], side, beyond[1], cv2.BORDER_REPLICATE)
    means, squares = (
        each(wider, cv2.CV_64F, (wide, tall), anchor=(0, 0)) for each in (cv2.boxFilter, cv2.sqrBoxFilter)
    )
    deviations = np.sqrt(np.maximum(squares - means**2, min_deviation**2)).astype(np.float32)
    centred = blocks - blocks.mean(axis=(1, 2), keepdims=True)
    whole = np.zeros((len(blocks), BLOCK_SIZE, BLOCK_SIZE), np.float32)
    whole[:, :tall, :wide] = centred / (tall * wide * centred.std(axis=(1, 2), keepdims=True))
    best = np.ones(len(blocks), np.float32)
    _correlate(whole, places, wider, deviations, np.empty(_PADDED_POSITION_COUNT, np.float32), best)
    return best


@compiled(fastmath=True, noalias=True)
def _correlate(blocks, places, wider, deviations, line, best):  # type: ignore[no-untyped-def]
    for block in range(best.size):
        top, left, most = places[block, 0], places[block, 1], np.float32(0)
        for row in range(top, top + _POSITION_COUNT):
            line[:] = 0
            for y in range(BLOCK_SIZE):
                _add_products(
                    blocks[block, y], wider[row + y, left : left + BLOCK_SIZE + _PADDED_POSITION_COUNT], line
                )
            for place in range(_POSITION_COUNT):
                most = max(most, line[place] / deviations[row, left + place])
        best[block] = most


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
