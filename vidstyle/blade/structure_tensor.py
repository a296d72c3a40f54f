"""Structure tensor features, and the selection of filters by them.

Paper, section 5.3, equations 6 to 10: gradients from differences along the diagonals of 2 x 2 pixels, the
structure tensor smoothed by a Gaussian, and its orientation, strength and coherence in uniform bins. The
Gaussian has an even number of taps, so that its window is centred on the pixel, and the bins of orientation
are centred on its multiples: a rotated or mirrored picture then selects the rotated or mirrored filters.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from vidstyle.core.kernels import compiled, index_at

LANES = 8
"""Pixels that are filtered together in vector registers."""
EPSILON = 1e-12
"""Added to divisors: a flat picture has coherence 0."""


@dataclass(frozen=True)
class Feature:
    """A further feature by which filters are chosen.

    Attributes:
        name: "mean", the local mean of luma, a Gaussian; or "strength" or "coherence" as in `Bins`, of a
            tensor with a window of its own.
        bins: their number.
        rho: standard deviation of the window in pixels.
        ends: of the range of the uniform bins, in levels of 255 but for coherence; None for `FEATURES`.
    """

    name: str
    bins: int
    rho: float
    ends: tuple[float, float] | None = None

    @property
    def range(self) -> tuple[float, float]:
        """The ends of its bins."""
        return FEATURES[self.name] if self.ends is None else self.ends

    @property
    def start_and_density(self) -> tuple[np.float32, np.float32]:
        """Of the bins of a mean: where they start, from 0 to 1, and their number per unit."""
        low, high = self.range
        return np.float32(low / 255), np.float32(255 * self.bins / (high - low))

    @property
    def tensor_bins(self) -> Bins:
        """The bins of this feature of a tensor alone."""
        if self.name == "strength":
            return Bins(1, self.bins, 1, strength_range=self.range)
        return Bins(1, 1, self.bins, coherence_range=self.range)


FEATURES = {"mean": (0.0, 255.0), "strength": (10.0, 40.0), "coherence": (0.2, 0.8)}
"""Names of features, and the ranges of their bins where nothing else is said."""


@dataclass(frozen=True)
class Bins:
    """The quantization of the features. Values outside a range fall into the bin at its end.

    Attributes:
        orientations: bins of the gradient's direction over half a turn, the first centred on "to the right".
        strengths: bins of the square root of the larger eigenvalue, in levels of 255 per pixel.
        coherences: bins of (a - b) / (a + b), where a and b are the roots of the two eigenvalues.
        strength_range, coherence_range: the ranges of the uniform bins.
        features: further features, each of which divides every bin into its own.
    """

    orientations: int = 24
    strengths: int = 1
    coherences: int = 3
    strength_range: tuple[float, float] = FEATURES["strength"]
    coherence_range: tuple[float, float] = FEATURES["coherence"]
    features: tuple[Feature, ...] = ()

    @property
    def counts(self) -> tuple[int, int, int]:
        """The numbers of bins of the three features."""
        return self.orientations, self.strengths, self.coherences

    @property
    def count(self) -> int:
        """The number of filters: orientation x strength x coherence x features, the last varying fastest."""
        return math.prod((*self.counts, *(each.bins for each in self.features)))

    @property
    def is_finite(self) -> bool:
        """Whether kernels can work with the ranges."""
        arrays = (self.as_array, *(each.tensor_bins.as_array for each in self.features))
        return all(bool(np.isfinite(each).all()) for each in arrays)

    @property
    def as_array(self) -> np.ndarray:
        """For kernels, seven float32: the counts, then start and bins per unit of both ranges."""
        low, high = self.strength_range
        first, last = self.coherence_range
        densities = 255 * self.strengths / (high - low), self.coherences / (last - first)
        with np.errstate(over="ignore"):
            return np.array([*self.counts, low / 255, densities[0], first, densities[1]], np.float32)


def window_radius(rho: float) -> int:
    """The radius of the tensor's window in pixels."""
    return max(1, math.ceil(2 * rho))


@lru_cache(maxsize=64)
def window_weights(rho: float) -> np.ndarray:
    """The weights of the even Gaussian of standard deviation rho: float32, they add up to 1.

    >>> window_weights(0.5).round(3).tolist()
    [0.5, 0.5]
    """
    radius = window_radius(rho)
    weights = np.exp(-((np.arange(2 * radius) - radius + 0.5) ** 2) / (2 * max(rho, 0.1) ** 2))
    return (weights / weights.sum()).astype(np.float32)


def select_filters(luma: np.ndarray, bins: Bins, rho: float, margin: tuple[int, int] = (0, 0)) -> np.ndarray:
    """The index of the filter for each pixel.

    Args:
        luma: H x W float32 0..1; beyond its border the border is repeated.
        bins: the quantization of the features.
        rho: standard deviation of the window in pixels.
        margin: first and last rows that need no filter.

    Returns:
        H x W int32, part of an array whose width is a multiple of `LANES`; undefined in the margin.
    """
    weights, (height, width) = window_weights(rho), luma.shape
    # Padded by columns of filter 0 for `apply_filters`, which filters several pixels together.
    selected = np.zeros((height, -(-width // LANES) * LANES), np.int32)
    padded = pad_edges(luma, len(weights) // 2)
    taps, columns = len(weights), padded.shape[1] - 1
    products, tensor = np.empty((taps, 3, columns), np.float32), np.empty((3, columns), np.float32)
    sums = tensor.reshape(-1)[: 3 * columns - taps + 1]
    scratch = products, products.reshape(taps, -1), np.empty(3 * columns, np.float32), sums, tensor
    _select(padded, weights, bins.as_array, margin[0], height - margin[1], scratch, selected, width)
    return selected[:, :width]


def pad_edges(luma: np.ndarray, margin: int, right: int = 0) -> np.ndarray:
    """Luma with its border repeated on all sides, by some more columns on the right."""
    sides = margin, margin, margin, margin + right
    return cv2.copyMakeBorder(np.ascontiguousarray(luma), *sides, cv2.BORDER_REPLICATE)


@compiled(fastmath=True)
def _select(padded, weights, bins, top, bottom, scratch, selected, width):  # type: ignore[no-untyped-def]
    """Row by row; the products of the last rows are kept, the window is applied vertically, then across.

    The three products of a row are contiguous, so that one loop covers them all. The result has padded rows,
    which are cut here: a part of an array that comes from Python has a stride, and no loop of vectors.
    """
    taps = len(weights)
    products, rows, narrow, sums, tensor = scratch
    for last in range(top, bottom + taps - 1):
        _multiply(padded[last], padded[last + 1], products[last % taps])
        row = last - taps + 1
        if row >= top:
            for tap in range(0, taps // 2, 2):
                upper, lower = rows[(row + tap) % taps], rows[(last - tap) % taps]
                beside = min(tap + 1, taps // 2 - 1)
                inner, outer = rows[(row + beside) % taps], rows[(last - beside) % taps]
                second = weights[beside] if beside > tap else np.float32(0)
                _weigh(upper, lower, weights[tap], inner, outer, second, tap == 0, narrow)
            for tap in range(0, taps // 2, 2):
                beside = min(tap + 1, taps // 2 - 1)
                second = weights[beside] if beside > tap else np.float32(0)
                left, right = narrow[tap:], narrow[taps - 1 - tap :]
                inner, outer = narrow[beside:], narrow[taps - 1 - beside :]
                _weigh(left, right, weights[tap], inner, outer, second, tap == 0, sums)
            _quantize(tensor, bins, selected[row, :width])


@compiled(fastmath=True)
def _weigh(one, other, weight, inner, outer, second, first, total):  # type: ignore[no-untyped-def]
    """Add two weighted pairs of rows to a total, or start it with them."""
    if first:
        for x in range(total.shape[0]):
            total[x] = weight * (one[x] + other[x]) + second * (inner[x] + outer[x])
    else:
        for x in range(total.shape[0]):
            total[x] += weight * (one[x] + other[x]) + second * (inner[x] + outer[x])


@compiled(fastmath=True)
def _multiply(above, below, products):  # type: ignore[no-untyped-def]
    """Squares and product of the differences along both diagonals, between four pixels each."""
    half = np.float32(0.5)
    for x in range(products.shape[1]):
        falling, rising = below[x + 1] - above[x], above[x + 1] - below[x]
        products[0, x] = half * falling * falling
        products[1, x] = half * falling * rising
        products[2, x] = half * rising * rising


@compiled(fastmath=True)
def _quantize(tensor, bins, selected):  # type: ignore[no-untyped-def]
    """The bins of a row. In the rotated axes of the differences, gx^2 - gy^2 is 2 b and 2 gx gy is a - c."""
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    orientations, strengths, coherences = np.int32(bins[0]), np.int32(bins[1]), np.int32(bins[2])
    per_turn = bins[0] * np.float32(1 / (2 * math.pi))
    pi, straight = np.float32(math.pi), np.float32(math.pi / 2)
    least = np.float32(EPSILON)
    for x in range(selected.shape[0]):
        a, b, c = tensor[0, x], tensor[1, x], tensor[2, x]
        right, up, total = b + b, a - c, a + c
        spread = np.sqrt(right * right + up * up)
        other = np.sqrt(max(a * c - b * b, zero))
        coherence = spread / (total + other + other + least)
        strength = np.sqrt(half * (total + spread))
        # The arctangent of Rajan et al. 2006, equation 10: off by 0.22 degrees at most.
        lower, higher = min(abs(right), abs(up)), max(abs(right), abs(up))
        slope = lower / (higher + least)
        angle = slope * (np.float32(math.pi / 4) + np.float32(0.273) * (one - slope))
        angle = straight - angle if abs(up) > abs(right) else angle
        angle = pi - angle if right < zero else angle
        angle = -angle if up < zero else angle
        orientation = np.int32(np.floor(angle * per_turn + half))
        orientation = orientation + orientations if orientation < 0 else orientation
        level = index_at(min(max((strength - bins[3]) * bins[4], zero), bins[1] - half), strengths - 1)
        clearness = index_at(min(max((coherence - bins[5]) * bins[6], zero), bins[2] - half), coherences - 1)
        orientation = min(max(orientation, np.int32(0)), orientations - np.int32(1))
        selected[x] = (orientation * strengths + level) * coherences + clearness
