"""Visual similarity of pictures: the same objects in the same places and in the same colours."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

THUMBNAIL_SIZE = 48, 32
"""Width and height in pixels of the thumbnails that are compared, for pictures of any aspect."""
DIFFERENT_SIMILARITY, SAME_SIMILARITY = 0.3, 0.5
"""Pictures below the first value look different; pictures above the second look nearly the same.

They were tuned on a trailer of 26 shots: views of one hall from one side, with people in other places, have
0.51 to 0.77, other pictures of one place up to 0.44, and pictures of different places up to 0.36.
"""

# Correlation of blocks.
_BLOCK_SIDE_PX, _SEARCH_RANGE_PX, _SEARCH_STEP_PX = 8, 4, 2
"""Block size, search range and search step."""
_FULL_WEIGHT_DEVIATION = 0.06
"""Standard deviation of luma, 0..1, from which a block has its full weight."""
_NOISE_DEVIATION = 0.02
"""Standard deviations below this value are treated as noise."""
_CORRELATION_RANGE = 0.45, 0.75
"""Range of block correlation, from unrelated pictures to the same view."""

# Travel of the camera.
_TRAVELLED_CORRELATION_RANGE, TRAVEL_WEIGHT = (0.64, 0.72), 0.3
"""Range of block correlation from another view, to which the camera has travelled, to the same view; and how
much less alike another view of the same colours is.

In a flight of 13 seconds along a coast and over a bridge, frames half a second apart have 0.76 to 0.9, and
frames that show the bridge from afar, from near and from above have 0.56 to 0.67.
"""

# Common colours.
_COMMON_COLOR_RANGE = 0.6, 0.9
"""Range of histogram intersection, from unrelated pictures to the same view."""
_LIGHTNESS_BINS, _CHROMA_BINS = 8, 10
"""Number of histogram bins along lightness and along each chroma axis."""
_MAX_CHROMA_LEVELS = 50
"""Chroma at the ends of the histogram, to either side of neutral, of 128."""

# Correlation of large forms.
_FORMS_SIDE_PX = 12
"""Side of the copies that are correlated."""


def similarity(copies: Sequence[np.ndarray]) -> np.ndarray:
    """Return the pairwise similarity of pictures by their thumbnails: N x N float32, 0 different, 1 the same.

    It is the mean of three measures, each of which misses something that the others see: the correlation of
    blocks of one picture near their place in the other, independent of brightness; the share of common
    colours; and the correlation of large forms.
    """
    return compare_views(copies)[0]


def compare_views(copies: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the similarity of pictures and how far the camera has travelled between two: each N x N, 0..1.

    The latter is 1 if hardly any block of one picture is found near its place in the other, though sky and
    sea may have kept their colours and large forms.
    """
    small = np.stack(list(copies))
    lab = np.stack([cv2.cvtColor(each, cv2.COLOR_RGB2LAB) for each in small]).astype(np.float32)
    found = _correlate_blocks(lab[..., 0] / 255)
    blocks = np.minimum(found, found.T)
    parts = (
        _normalize_range(blocks, _CORRELATION_RANGE),
        _normalize_range(_common_colors(lab), _COMMON_COLOR_RANGE),
        _correlate_forms(small),
    )
    travelled = 1 - _normalize_range(blocks, _TRAVELLED_CORRELATION_RANGE)
    return np.asarray(sum(parts) / len(parts), np.float32), travelled


def color_similarity(one: np.ndarray, other: np.ndarray) -> float:
    """Return the histogram intersection of two pictures of any sizes, H x W x 3 uint8: 0..1."""
    first, second = (
        _histogram(cv2.cvtColor(each, cv2.COLOR_RGB2LAB).astype(np.float32)) for each in (one, other)
    )
    return float(np.minimum(first, second).sum())


def make_thumbnail(color: np.ndarray) -> np.ndarray:
    """Return the copy of a picture, H x W x 3 uint8, that is compared."""
    return cv2.resize(color, THUMBNAIL_SIZE, interpolation=cv2.INTER_AREA)


def _normalize_range(measure: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    return ((measure - ends[0]) / (ends[1] - ends[0])).clip(0, 1)


def _correlate_blocks(lumas: np.ndarray) -> np.ndarray:
    """Return the best correlation of each picture's blocks (column) near their place in each picture (row).

    Args:
        lumas: N x H x W, 0..1.
    """
    around = ((0, 0), (_SEARCH_RANGE_PX, _SEARCH_RANGE_PX), (_SEARCH_RANGE_PX, _SEARCH_RANGE_PX))
    windows, _ = _standardize(_extract_blocks(np.pad(lumas, around, mode="edge"), _SEARCH_STEP_PX))
    blocks, deviations = _standardize(_extract_blocks(lumas, _BLOCK_SIDE_PX))
    weights = np.minimum(1, deviations / _FULL_WEIGHT_DEVIATION)
    found = np.zeros((len(lumas), len(lumas)), np.float32)
    apart, shifts = _BLOCK_SIDE_PX // _SEARCH_STEP_PX, 2 * _SEARCH_RANGE_PX // _SEARCH_STEP_PX + 1
    for row, column in np.ndindex(blocks.shape[1:3]):
        top, left = row * apart, column * apart
        near = windows[:, top : top + shifts, left : left + shifts]
        correlations = near.reshape(len(lumas), shifts * shifts, -1) @ blocks[:, row, column].T
        found += correlations.max(axis=1) * weights[:, row, column]
    return found / (weights.sum(axis=(1, 2)) + np.float32(1e-3))


def _extract_blocks(lumas: np.ndarray, step: int) -> np.ndarray:
    """Return all blocks of each picture whose corners are on a grid: N x rows x columns x pixels."""
    windows = np.lib.stride_tricks.sliding_window_view(lumas, (_BLOCK_SIDE_PX, _BLOCK_SIDE_PX), axis=(1, 2))[
        :, ::step, ::step
    ]
    return windows.reshape(*windows.shape[:3], -1)


def _standardize(blocks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return blocks (last axis) normalized to mean 0 and length 1, and their standard deviations."""
    blocks = blocks - blocks.mean(axis=-1, keepdims=True)
    deviations = np.sqrt((blocks**2).mean(axis=-1))
    return blocks / (np.maximum(deviations, _NOISE_DEVIATION) * _BLOCK_SIDE_PX)[..., np.newaxis], deviations


def _common_colors(lab: np.ndarray) -> np.ndarray:
    """Return the histogram intersections of pictures in Lab, N x H x W x 3 of 0..255: N x N."""
    histograms = np.stack([_histogram(each) for each in lab])
    return np.stack([np.minimum(each, histograms).sum(axis=1) for each in histograms])


def _histogram(lab: np.ndarray) -> np.ndarray:
    """Return a colour histogram of sum 1, blurred so that a small change of light hardly changes it."""
    chroma = (128 - _MAX_CHROMA_LEVELS, 128 + _MAX_CHROMA_LEVELS)
    counts = cv2.calcHist(
        [lab], [0, 1, 2], None, [_LIGHTNESS_BINS, _CHROMA_BINS, _CHROMA_BINS], [0, 256, *chroma, *chroma]
    )
    for axis in range(3):
        middle = np.moveaxis(counts, axis, 0)
        low, high = np.concatenate([middle[:1], middle[:-1]]), np.concatenate([middle[1:], middle[-1:]])
        counts = np.moveaxis((low + 2 * middle + high) / 4, 0, axis)
    return np.asarray(counts.ravel() / max(counts.sum(), 1e-6), np.float32)


def _correlate_forms(small: np.ndarray) -> np.ndarray:
    """Return the correlations of pictures, N x H x W x 3 uint8, reduced to a few pixels: N x N, 0..1."""
    size = _FORMS_SIDE_PX, _FORMS_SIDE_PX
    thumbs = np.stack([cv2.resize(each, size, interpolation=cv2.INTER_AREA).ravel() for each in small]) / 255
    thumbs = thumbs - thumbs.mean(axis=1, keepdims=True)
    lengths = np.sqrt((thumbs**2).sum(axis=1, keepdims=True))
    thumbs = thumbs / np.maximum(lengths, _NOISE_DEVIATION * np.sqrt(thumbs.shape[1]))
    return (thumbs @ thumbs.T).clip(0, 1)
