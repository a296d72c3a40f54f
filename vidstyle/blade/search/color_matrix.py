"""Finds the colour matrix by which a filter mixes the channels, if it does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vidstyle.blade.photographs import chroma_of, luma_of
from vidstyle.core.color.deferred_color import Mixed
from vidstyle.core.resample import resample, scaled_shape

BLOCK_PX = 8
"""Side of the squares whose means are compared, so that sharpening or blurring has little effect."""
TONE_BINS = 8
"""Bins of the tone curve that a bank is assumed to learn."""
MIN_BLOCK_COUNT = 50
"""Minimum number of blocks without black or white results from which a matrix is found."""
MIN_MATRIX_GAIN = 0.003
"""The part of the change that a matrix must explain in addition to tone curves, on held-out pictures."""


@dataclass(frozen=True)
class _Means:
    """Means of blocks of a picture, N x 3 float32.

    Attributes:
        color, target: RGB of the picture and of the filter's result.
        is_clipped: N booleans, whether the result has black or white values.
        change: the mean squared change of the planes that are learned.
    """

    color: np.ndarray
    target: np.ndarray
    is_clipped: np.ndarray
    change: float


def find_color_matrix(
    pictures: Sequence[tuple[np.ndarray, np.ndarray]], chroma: bool = False
) -> np.ndarray | None:
    """Return the matrix that explains a filter's colours, 3 x 4 float32, or None if it explains too little.

    It is found by least squares on one half of the pictures, checked on the other half, and the other way
    round. A bank that reads only luma learns tone curves; a matrix must explain more than these.

    Args:
        pictures: RGB, H x W x 3 float32 0..1, and the result of the filter: RGB, or luma, H x W.
        chroma: whether chroma is learned, too.
    """
    if not pictures:
        return None
    means = [_means(*each, chroma) for each in pictures]
    halves = [means[::2], means[1::2] or means]
    gain = change = 0.0
    for learned, checked in (halves, halves[::-1]):
        matrix = _solved(learned)
        if matrix is None:
            return None
        mixed = [Mixed(each.color[None], matrix).whole()[0] for each in checked]
        plain = [each.color for each in checked]
        target = np.concatenate([each.target for each in checked])
        before, after = (_tone_error(np.concatenate(colors), target, chroma) for colors in (plain, mixed))
        gain += before - after
        change += float(np.mean([each.change for each in checked]))
    return _solved(means) if 0 < MIN_MATRIX_GAIN * change <= gain else None


def square_of(target: np.ndarray, luma: np.ndarray, chroma: Sequence[np.ndarray]) -> float:
    """Return the mean squared difference of a picture from luma, and from both chroma planes if given."""
    planes = [luma_of(target) - luma]
    planes += [new - old for new, old in zip(chroma_of(target), chroma, strict=False)]
    return float(sum(np.square(each, dtype=np.float64).mean() for each in planes))


def _means(color: np.ndarray, target: np.ndarray, chroma: bool) -> _Means:
    target = target if target.ndim == 3 else np.repeat(target[..., None], 3, axis=2)
    shape = scaled_shape((color.shape[0], color.shape[1]), 1 / BLOCK_PX)
    ends = ((target <= 0) | (target >= 1)).any(axis=2).astype(np.float32)
    blocks = [resample(np.ascontiguousarray(each), shape, "area") for each in (color, target, ends)]
    flat = [each.reshape(-1, *each.shape[2:]) for each in blocks]
    return _Means(
        flat[0], flat[1], flat[2] > 0, square_of(target, luma_of(color), chroma_of(color) if chroma else [])
    )


def _solved(means: Sequence[_Means]) -> np.ndarray | None:
    """Return the matrix that is closest to the targets, or None if there are too few blocks."""
    color, target = (
        np.concatenate([getattr(each, name)[~each.is_clipped] for each in means])
        for name in ("color", "target")
    )
    if len(color) < MIN_BLOCK_COUNT:
        return None
    known = np.column_stack([color, np.ones(len(color))]).astype(np.float64)
    moments = known.T @ known + 1e-6 * len(known) * np.eye(4)  # toward no change, if pictures are gray
    found = np.linalg.solve(moments, known.T @ target + 1e-6 * len(known) * np.eye(4, 3))
    return np.asarray(found.T, np.float32)


def _tone_error(color: np.ndarray, target: np.ndarray, chroma: bool) -> float:
    """Return the mean squared error after a tone curve of luma, and with `chroma` a gain of each plane."""
    luma, wanted = luma_of(color[None])[0], luma_of(target[None])[0].astype(np.float64)
    tones = np.clip(luma * TONE_BINS, 0, TONE_BINS - 1).astype(int)
    error = 0.0
    for tone in np.unique(tones):
        error += _linear_error(luma[tones == tone], wanted[tones == tone])
    if chroma:
        for plane, each in zip(chroma_of(color[None]), chroma_of(target[None]), strict=True):
            error += _linear_error(plane[0], each[0].astype(np.float64))
    return error / len(luma)


def _linear_error(known: np.ndarray, wanted: np.ndarray) -> float:
    """Return the sum of squared errors of the best linear function of some numbers."""
    centred, rest = known - known.mean(dtype=np.float64), wanted - wanted.mean()
    slope = float(centred @ rest) / (float(centred @ centred) + 1e-9)
    return float(np.square(rest - slope * centred).sum())
