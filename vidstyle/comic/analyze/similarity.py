"""Visual similarity of pictures: the same objects in the same places, in the same colours."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

SIZE = 48, 32
"""Width and height of the thumbnails that are compared, whatever the pictures' aspect."""
DIFFERENT, SIMILAR = 0.3, 0.5
"""Pictures less alike than the first look different, those more alike than the second nearly the same.

Chosen on a trailer of 26 shots: views of one hall from one side, with the people in it standing elsewhere,
are at 0.51 to 0.77, other pictures of one place at 0.44 and below, of different places at 0.36 and below.
"""

_BLOCK, _REACH, _STEP = 8, 4, 2
"""Block size, search range and search step, in pixels."""
_FLAT = 0.06
"""Standard deviation of luma below which a block counts less, 0..1."""
_NOISE = 0.02
"""Standard deviations below are treated as noise."""
_FOUND, _SHARED = (0.45, 0.75), (0.6, 0.9)
"""Ranges of block correlation and histogram intersection, from unrelated pictures to the same view."""
_LIGHTNESS, _CHROMA = 8, 10
"""Bins of the histogram along lightness and along each chroma,"""
_WIDE = 50
"""which end at so much chroma to either side, of 128."""
_THUMB = 12


def similarity(copies: Sequence[np.ndarray]) -> np.ndarray:
    """Pairwise similarity of pictures by their thumbnails: N x N float32, 0 different, 1 the same.

    The mean of three measures, each of which is blind to something: how well blocks of one are found near
    their place in the other, whatever their brightness; how much of their colours they share; and how their
    largest forms correlate.
    """
    small = np.stack(list(copies))
    lab = np.stack([cv2.cvtColor(each, cv2.COLOR_RGB2LAB) for each in small]).astype(np.float32)
    found = _found(lab[..., 0] / 255)
    parts = _scaled(np.minimum(found, found.T), _FOUND), _scaled(_shared(lab), _SHARED), _forms(small)
    return np.asarray(sum(parts) / len(parts), np.float32)


def make_thumbnail(color: np.ndarray) -> np.ndarray:
    """The copy of a picture, H x W x 3 uint8, that is compared."""
    return cv2.resize(color, SIZE, interpolation=cv2.INTER_AREA)


def _scaled(measure: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    return ((measure - ends[0]) / (ends[1] - ends[0])).clip(0, 1)


def _found(lumas: np.ndarray) -> np.ndarray:
    """The best correlation of the blocks of each picture (column) near their place in each other (row).

    Args:
        lumas: N x H x W, 0..1.
    """
    around = ((0, 0), (_REACH, _REACH), (_REACH, _REACH))
    windows, _ = _normal(_windows(np.pad(lumas, around, mode="edge"), _STEP))
    blocks, deviations = _normal(_windows(lumas, _BLOCK))
    weights = np.minimum(1, deviations / _FLAT)
    found = np.zeros((len(lumas), len(lumas)), np.float32)
    apart, shifts = _BLOCK // _STEP, 2 * _REACH // _STEP + 1
    for row, column in np.ndindex(blocks.shape[1:3]):
        top, left = row * apart, column * apart
        near = windows[:, top : top + shifts, left : left + shifts]
        correlations = near.reshape(len(lumas), shifts * shifts, -1) @ blocks[:, row, column].T
        found += correlations.max(axis=1) * weights[:, row, column]
    return found / (weights.sum(axis=(1, 2)) + np.float32(1e-3))


def _windows(lumas: np.ndarray, step: int) -> np.ndarray:
    """All blocks of each picture whose corners are on a grid: N x rows x columns x pixels."""
    windows = np.lib.stride_tricks.sliding_window_view(lumas, (_BLOCK, _BLOCK), axis=(1, 2))[
        :, ::step, ::step
    ]
    return windows.reshape(*windows.shape[:3], -1)


def _normal(blocks: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Blocks (last axis) normalized to mean 0 and length 1, and their standard deviations."""
    blocks = blocks - blocks.mean(axis=-1, keepdims=True)
    deviations = np.sqrt((blocks**2).mean(axis=-1))
    return blocks / (np.maximum(deviations, _NOISE) * _BLOCK)[..., np.newaxis], deviations


def _shared(lab: np.ndarray) -> np.ndarray:
    """Histogram intersection of pictures in Lab, N x H x W x 3 of 0..255: N x N."""
    histograms = np.stack([_histogram(each) for each in lab])
    return np.stack([np.minimum(each, histograms).sum(axis=1) for each in histograms])


def _histogram(lab: np.ndarray) -> np.ndarray:
    """A colour histogram of sum 1, blurred so that a little more light hardly changes it."""
    chroma = (128 - _WIDE, 128 + _WIDE)
    counts = cv2.calcHist([lab], [0, 1, 2], None, [_LIGHTNESS, _CHROMA, _CHROMA], [0, 256, *chroma, *chroma])
    for axis in range(3):
        middle = np.moveaxis(counts, axis, 0)
        low, high = np.concatenate([middle[:1], middle[:-1]]), np.concatenate([middle[1:], middle[-1:]])
        counts = np.moveaxis((low + 2 * middle + high) / 4, 0, axis)
    return np.asarray(counts.ravel() / max(counts.sum(), 1e-6), np.float32)


def _forms(small: np.ndarray) -> np.ndarray:
    """Correlation of pictures, N x H x W x 3 uint8, reduced to a few pixels: N x N, 0..1."""
    size = _THUMB, _THUMB
    thumbs = np.stack([cv2.resize(each, size, interpolation=cv2.INTER_AREA).ravel() for each in small]) / 255
    thumbs = thumbs - thumbs.mean(axis=1, keepdims=True)
    lengths = np.sqrt((thumbs**2).sum(axis=1, keepdims=True))
    thumbs = thumbs / np.maximum(lengths, _NOISE * np.sqrt(thumbs.shape[1]))
    return (thumbs @ thumbs.T).clip(0, 1)
