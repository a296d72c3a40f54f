"""Sampling of luma for percentiles and scene cuts, and smoothing of percentiles over time."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vidstyle.core.picture import Picture
from vidstyle.core.planes import luma_from_rgb

MAX_SIDE_SAMPLES = 320
"""Largest side of a small copy in pixels."""
MAX_QUANTILE_SAMPLES = 8192
"""Values of which a quantile is taken, at most."""
SMOOTHING_STEP = 2.0**-32
"""Unit of smoothed numbers, which are 0..1: far below what changes a picture."""


@dataclass(frozen=True)
class Sampling:
    """The pixels of a small copy: every n-th across and down, from the middle of each square.

    Pixels are not averaged, so the copy has the percentiles of the picture.

    Attributes:
        stride: n.
        first: row and column of the first one.
        shape: rows and columns of the copy.
    """

    stride: int
    first: tuple[int, int]
    shape: tuple[int, int]

    @classmethod
    def of(cls, height: int, width: int, most: int = MAX_SIDE_SAMPLES) -> Sampling:
        """Return the sampling of a picture of this size, of at most `most` pixels on a side.

        >>> Sampling.of(1080, 1920)
        Sampling(stride=6, first=(2, 2), shape=(180, 320))
        """
        stride = -(-max(height, width) // most)
        top, left = (min((stride - 1) // 2, (side - 1) // 2) for side in (height, width))
        return cls(stride, (top, left), (-(-(height - top) // stride), -(-(width - left) // stride)))


def sample_plane(plane: np.ndarray, most: int = MAX_SIDE_SAMPLES) -> np.ndarray:
    """Return the small copy of a plane, a view."""
    height, width = plane.shape[:2]
    sampling = Sampling.of(height, width, most)
    top, left = sampling.first
    return plane[top :: sampling.stride, left :: sampling.stride]


def sampled_values(picture: Picture, most: int = MAX_SIDE_SAMPLES) -> np.ndarray:
    """Return the small copy of a picture's luma or RGB, float32 with black at 0 and white at 1.

    Without kernels, so that a dry run of them has it too.
    """
    black, white = picture.encoding.luma_levels
    plane = picture.luma if picture.color is None else picture.color
    assert plane is not None
    span = white - black
    values = sample_plane(plane, most).astype(np.float32)  # in-place operations are five times as fast
    values *= np.float32(1 / span)
    values -= np.float32(black / span)
    return values


def small_luma(picture: Picture, most: int = MAX_SIDE_SAMPLES) -> np.ndarray:
    """Return a small copy of a picture's luma, float32, of at most `most` pixels on a side."""
    values = sampled_values(picture, most)
    return values if picture.color is None else luma_from_rgb(values, picture.encoding)


def percentiles(values: np.ndarray, percentages: Sequence[float]) -> np.ndarray:
    """Percentiles of all values, between two of which is interpolated as by `numpy.percentile`.

    That one imports NumPy's masked arrays, which takes longer than all percentiles of many frames.

    Returns:
        float64, one for each percentage, 0 to 100.
    """
    places = np.array(percentages, np.float64) / 100 * (values.size - 1)
    below = places.astype(np.intp)
    above = np.minimum(below + 1, values.size - 1)
    ordered = np.partition(values, sorted({*below.tolist(), *above.tolist()}), axis=None)
    low, high = (ordered[each].astype(np.float64) for each in (below, above))
    return low + (places - below) * (high - low)


def sampled_quantile(values: np.ndarray, share: float, *, default: float) -> float:
    """Return a quantile, 0..1, of at most `MAX_QUANTILE_SAMPLES` values; `default` if there are none."""
    every = -(-values.size // MAX_QUANTILE_SAMPLES)
    return float(percentiles(values.ravel()[::every], [100 * share])[0]) if every else default


def small_colors(picture: Picture, most: int) -> np.ndarray:
    """RGB of a small copy, H x W x 3 float64 within 0..1, with the chroma of the nearest sample.

    Without kernels, so that a dry run of them has it too.
    """
    encoding = picture.encoding
    black, white = encoding.luma_levels
    plane = picture.luma if picture.color is None else picture.color
    assert plane is not None
    values = (sample_plane(plane, most).astype(np.float64) - black) / (white - black)
    if picture.color is None:
        yuv = np.zeros((*values.shape, 3))
        yuv[..., 0] = values
        sampling, (across, down) = Sampling.of(*picture.shape, most), encoding.subsampling
        (top, left), (height, width) = sampling.first, sampling.shape
        rows, columns = (
            (top + sampling.stride * np.arange(height)) // down,
            (left + sampling.stride * np.arange(width)) // across,
        )
        for number, chroma in enumerate(picture.chroma or (), 1):
            neutral, span = encoding.chroma_levels
            yuv[..., number] = (chroma[np.ix_(rows, columns)] - neutral) / span
        values = sum(yuv[..., each, None] * encoding.to_rgb[:, each] for each in range(3))
    return np.clip(values, 0, 1)


class ExponentialSmoother:
    """First-order smoothing: p += (1 - e^(-dt/tau)) (measure - p), in steps of `SMOOTHING_STEP`.

    p reaches a constant measure, so that numbers which began differently become the same bit for bit.

    Attributes:
        numbers: the smoothed numbers after the last measurement; None before the first.
    """

    def __init__(self) -> None:
        self.numbers: np.ndarray | None = None
        self._time: float | None = None

    def restart(self) -> None:
        """Use the next measurement without smoothing."""
        self._time = None

    def blend_weight(self, time: float | None, time_constant: float) -> float:
        """Return the weight of the next measurement, 0..1; call it once for each.

        Args:
            time: presentation time in seconds; None for a picture that stands alone.
            time_constant: seconds; 0 follows at once.
        """
        before, self._time = self._time, time
        if before is None or time is None or time_constant == 0 or time < before:
            return 1.0
        return 1 - math.exp(-(time - before) / time_constant)

    def follow(self, measure: np.ndarray, time: float | None, time_constant: float) -> np.ndarray:
        """Return the smoothed numbers after this measurement; for the arguments see `blend_weight`."""
        weight = self.blend_weight(time, time_constant)
        if self.numbers is None or weight == 1:
            self.numbers = measure.copy()
        else:
            wanted, steps = np.rint(measure / SMOOTHING_STEP), self.numbers / SMOOTHING_STEP
            steps += weight * (wanted - steps)
            self.numbers = SMOOTHING_STEP * np.where(wanted > steps, np.ceil(steps), np.floor(steps))
        return self.numbers
