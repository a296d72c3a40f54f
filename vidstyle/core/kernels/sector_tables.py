"""Input of `sector_sums`: pairs of pixels around a picture, and weights of pairs in four lists."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.core.kernels.aligned import aligned_empty
from vidstyle.core.kernels.channels import interleaved
from vidstyle.core.kernels.declare import compiled
from vidstyle.core.kernels.sector_means import (
    COLOR_LEVELS,
    FULL_SECTOR_WEIGHT,
    HALF_SECTOR_COUNT,
    MAX_CODED_LEVEL,
    MIDDLE_SQUARE_LEVEL,
    MIN_CODED_LEVEL,
    SECTOR_COUNT,
    SQUARE_LEVELS,
)

OUTSIDE = np.array(
    [
        [(each - turn) % SECTOR_COUNT >= HALF_SECTOR_COUNT for turn in range(SECTOR_COUNT)]
        for each in range(SECTOR_COUNT)
    ],
    float,
)
"""By sector and turn, 1 where the sector is not one of four from the turn on."""


def pixel_pairs(picture: np.ndarray, rows: tuple[int, int], reach: int) -> np.ndarray:
    """Pairs of pixels of some rows of a picture, with those at its edge beyond it.

    Args:
        picture: H x W x 3, clipped to -1..2; or H x W x 4, from `square_means`.
        rows: the first one, and the one behind the last one; they may lie outside.
        reach: columns on both sides; on the left there is one more, in which opposite pairs begin.

    Returns:
        int32, rows x 4 numbers for each column, see `SectorSums`.
    """
    out = aligned_empty((rows[1] - rows[0], 4 * (picture.shape[1] + 2 * reach + 1))).view(np.int32)
    codes = np.empty(out.shape[1] + 4, np.int32)
    _surround(interleaved(picture), picture.shape[2], rows[0], reach + 1, codes, out)
    return out


def square_means(picture: np.ndarray, margin: tuple[int, int], radius: int, size: int) -> np.ndarray:
    """Means of squares of pixels around each one, and of the squares of their differences from the middle.

    Args:
        picture: H x W x 3, clipped to -1..2; its edge is repeated beyond it.
        margin: rows above and below those for which a result is wanted.
        radius: how far from these pixels all samples of a square lie, at most.
        size: of a square, odd.

    Returns:
        H x W x 4 float32, for all pixels whose square lies within the radius.
    """
    above, below = (radius - rows for rows in margin)
    around = cv2.copyMakeBorder(
        np.clip(picture, MIN_CODED_LEVEL, MAX_CODED_LEVEL), above, below, radius, radius, cv2.BORDER_REPLICATE
    )
    samples = np.empty((*around.shape[:2], 4), np.float32)
    samples[..., :3] = around
    around -= np.float32((MIN_CODED_LEVEL + MAX_CODED_LEVEL) / 2)
    samples[..., 3] = np.einsum("ijk,ijk->ij", around, around)
    del around  # as large as a band, 18 MB at 3840x2160
    weights, half = np.full(size, 1 / size, np.float32), size // 2
    return cv2.sepFilter2D(samples, cv2.CV_32F, weights, weights)[half:-half, half:-half]


@compiled
def _surround(picture, channels, top, left, codes, out):  # type: ignore[no-untyped-def]
    """Pairs of pixels for `sector_sums`, from row `top` on, with those at the edge beyond it.

    Args:
        left: columns before the first one of the picture.
        codes: scratch for one row and one pixel more.
    """
    first, last = 4 * left, 4 * left + picture.shape[1] // channels * 4
    for row in range(out.shape[0]):
        source = picture[min(max(top + row, 0), picture.shape[0] - 1)]
        if channels == 3:
            _encode(source, codes[first:last])
        else:
            _encode_means(source, codes[first:last])
        for i in range(first):
            codes[i] = codes[first + i % 4]
        for i in range(last, codes.size):
            codes[i] = codes[last - 4 + i % 4]
        _join(codes, out[row])


@compiled(noalias=True)
def _encode(row, codes):  # type: ignore[no-untyped-def]
    """Red, green, blue and the sum of their squares."""
    middle, most = (
        np.float32((MIN_CODED_LEVEL + MAX_CODED_LEVEL) / 2),
        np.float32((MAX_CODED_LEVEL - MIN_CODED_LEVEL) / 2),
    )
    scale, square_scale = np.float32(COLOR_LEVELS), np.float32(SQUARE_LEVELS)
    for x in range(row.size // 3):
        red = min(max(row[3 * x] - middle, -most), most)
        green = min(max(row[3 * x + 1] - middle, -most), most)
        blue = min(max(row[3 * x + 2] - middle, -most), most)
        square = red * red + green * green + blue * blue - np.float32(MIDDLE_SQUARE_LEVEL)
        codes[4 * x], codes[4 * x + 1] = np.int32(np.rint(red * scale)), np.int32(np.rint(green * scale))
        codes[4 * x + 2] = np.int32(np.rint(blue * scale))
        codes[4 * x + 3] = np.int32(np.rint(square * square_scale))


@compiled(noalias=True)
def _encode_means(row, codes):  # type: ignore[no-untyped-def]
    """Encode means, whose squares are given."""
    middle, scale = np.float32((MIN_CODED_LEVEL + MAX_CODED_LEVEL) / 2), np.float32(COLOR_LEVELS)
    for x in range(row.size // 4):
        for channel in range(3):
            codes[4 * x + channel] = np.int32(np.rint((row[4 * x + channel] - middle) * scale))
        square = row[4 * x + 3] - np.float32(MIDDLE_SQUARE_LEVEL)
        codes[4 * x + 3] = np.int32(np.rint(square * np.float32(SQUARE_LEVELS)))


@compiled(noalias=True)
def _join(codes, pairs):  # type: ignore[no-untyped-def]
    """Pack each pixel's codes into the low halves, and the codes of the next pixel into the high halves."""
    for i in range(pairs.size):
        pairs[i] = (codes[i] & np.int32(0xFFFF)) | (codes[i + 4] << np.int32(16))


def pair_lists(places: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of samples in four lists, as `sector_sums` reads them.

    Args:
        places: row and column of samples in one half of a point-symmetric area, row by row, n x 2.
        weights: of each in eight sectors, n x 8; the opposite samples have the same weights in the opposite
            sectors; together, the weights of each sector add up to 1.

    Returns:
        Places of the left samples, m x 4 x 2 int64, and weights of pairs, m x 4 x 4 int32.
    """
    return _in_lists(*_in_pairs(places, _codes(weights)))


def _codes(weights: np.ndarray) -> np.ndarray:
    """Return weights of half an ellipse as integers, n x 8.

    With the opposite half, the weights of each sector add up to `FULL_SECTOR_WEIGHT`.
    """
    opposite = weights.reshape(-1, 2, HALF_SECTOR_COUNT).swapaxes(0, 1)
    ends = np.rint(FULL_SECTOR_WEIGHT * np.cumsum(opposite.reshape(-1, HALF_SECTOR_COUNT), axis=0))
    codes = np.diff(ends, axis=0, prepend=0).astype(np.int16).reshape(opposite.shape)
    return codes.swapaxes(0, 1).reshape(-1, SECTOR_COUNT)


def _in_pairs(places: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return adjacent samples of a row: places of the left ones, n x 2, and weights of both, n x 2 x 8."""
    rows = places[:, 0]
    left = np.flatnonzero((np.arange(len(rows)) - np.searchsorted(rows, rows)) % 2 == 0)
    is_beside = np.append(rows[1:] == rows[:-1], False)
    right = np.where(is_beside[:, None], np.roll(weights, -1, axis=0), 0)
    return places[left], np.stack([weights, right], axis=1)[left]


def _in_lists(places: np.ndarray, weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Group pairs of samples by the first one of their four sectors.

    Pairs of the opposite four sectors are reversed. A pair with more sectors counts as two pairs.

    Returns:
        Places of the left samples, n x 4 x 2, and weights, n x 4 x 4 pairs of int16 in one int32.
    """
    fits = weights.sum(axis=1) @ OUTSIDE == 0
    lists: list[list[tuple[int, int]]] = [
        [] for _ in range(HALF_SECTOR_COUNT)
    ]  # pairs, and the first of four sectors
    for pair in np.argsort(fits.sum(axis=1), kind="stable").tolist():  # those first that fit few lists
        possible = np.flatnonzero(fits[pair]).tolist()
        turn = min(
            possible or range(HALF_SECTOR_COUNT), key=lambda turn: len(lists[turn % HALF_SECTOR_COUNT])
        )
        lists[turn % HALF_SECTOR_COUNT] += (
            [(pair, turn)] if possible else [(pair, turn), (pair, turn + HALF_SECTOR_COUNT)]
        )
    length = max(map(len, lists))
    listed_places = np.zeros((length, HALF_SECTOR_COUNT, 2), np.int64)
    listed_weights = np.zeros((length, HALF_SECTOR_COUNT, HALF_SECTOR_COUNT, 2), np.int16)
    for column, each in enumerate(lists):
        pairs, turns = np.array(each, np.int64).reshape(-1, 2, 1).swapaxes(0, 1)
        sectors, own = (
            (turns + (np.arange(HALF_SECTOR_COUNT) - turns) % HALF_SECTOR_COUNT) % SECTOR_COUNT,
            places[pairs[:, 0]],
        )
        listed_places[: len(each), column] = np.where(turns < HALF_SECTOR_COUNT, own, -own - (0, 1))
        straight, is_turned = weights[pairs, :, sectors], turns[..., None] >= HALF_SECTOR_COUNT
        listed_weights[: len(each), column] = np.where(is_turned, straight[..., ::-1], straight)
    return listed_places, listed_weights.view(np.int32)[..., 0]
