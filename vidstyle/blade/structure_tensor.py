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
UNROLLED = 64
"""Numbers that a compiled loop takes at a time; what is left over takes as long one by one."""
PAIRS_AT_ONCE = 5
"""The most pairs of products, equally far from the middle of a window, that are added in one go."""
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
        step: side of the squares of pixels that share a filter: 1, or 2, which is four times as fast.
    """

    orientations: int = 24
    strengths: int = 1
    coherences: int = 3
    strength_range: tuple[float, float] = FEATURES["strength"]
    coherence_range: tuple[float, float] = FEATURES["coherence"]
    features: tuple[Feature, ...] = ()
    step: int = 1

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


def half_window(rho: float, step: int) -> np.ndarray:
    """The weights of one half of the window in which filters are chosen, from its end to its middle: float32.

    Of `window_weights`, or where filters are chosen for squares of 2 x 2 pixels, of the odd Gaussian that is
    centred on the middle of a square and one tap shorter.
    """
    radius = window_radius(rho)
    if step == 1:
        return window_weights(rho)[:radius]
    weights = np.exp(-((np.arange(1 - radius, 1)) ** 2) / (2 * max(rho, 0.1) ** 2))
    return (weights / (2 * weights.sum() - 1)).astype(np.float32)


def select_filters(
    luma: np.ndarray, bins: Bins, rho: float, margin: tuple[int, int] = (0, 0), top: int = 0
) -> np.ndarray:
    """The index of the filter for each square of `bins.step` pixels.

    Args:
        luma: H x W float32 0..1; beyond its border the border is repeated.
        bins: the quantization of the features.
        rho: standard deviation of the window in pixels.
        margin: first and last rows that need no filter.
        top: the number of luma's first row in the whole picture, whose squares begin at multiples of `step`.

    Returns:
        int32, as many as there are squares of which luma has any pixel, part of an array whose width is that
        of a multiple of `LANES`; undefined in the margin.
    """
    step, weights, (height, width) = bins.step, half_window(rho, bins.step), luma.shape
    taps, radius, lead = 2 * len(weights) + 1 - step, len(weights), top % step
    if step == 2:
        weights = np.append(weights[:-1], weights[-1] / 2)  # as a pair, the middle counts twice
    at_once = -(-radius // -(-radius // PAIRS_AT_ONCE))
    columns = _rounded_up(width, LANES)
    wide = _rounded_up(columns + taps - 1, UNROLLED)
    taps_of_row = np.arange(taps)
    scratch = (
        np.empty((taps, 3, wide), np.float32),
        np.empty(taps, np.uint64),
        np.empty(3 * wide + taps, np.float32),
        np.empty(3 * wide + taps, np.float32),
        (taps_of_row % step * (3 * wide // step) + taps_of_row // step).astype(np.uint64),
        np.empty((3, wide // step), np.float32),
    )
    selected = np.empty((-(-(height + lead) // step), columns // step), np.int32)
    _select(
        np.ascontiguousarray(luma),
        np.pad(weights, (0, -radius % at_once)),
        (0,) * at_once,
        bins.as_array,
        ((margin[0] + lead) // step, -(-(height - margin[1] + lead) // step)),
        (step - 1 - lead - radius, radius + 1 - step),
        step,
        scratch,
        scratch[0].reshape(-1),
        scratch[-1].reshape(-1),
        selected,
    )
    return selected[:, : -(-width // step)]


def _rounded_up(number: int, multiple: int) -> int:
    return -(-number // multiple) * multiple


def pad_edges(luma: np.ndarray, margin: int, right: int = 0) -> np.ndarray:
    """Luma with its border repeated on all sides, by some more columns on the right."""
    sides = margin, margin, margin, margin + right
    return cv2.copyMakeBorder(np.ascontiguousarray(luma), *sides, cv2.BORDER_REPLICATE)


@compiled(fastmath=True)
def _select(  # type: ignore[no-untyped-def]
    luma, weights, pairs, bins, rows, first, step, scratch, flat_products, flat_sums, selected
):
    """Row by row; the products of the last rows are kept, the window is applied vertically, then across.

    The three products of a row are contiguous, so that one loop covers them all.

    Args:
        pairs: a tuple whose length is the number of pairs of taps that are added in one go.
        rows: the first row of squares, and the one after the last.
        first: the row of products with which the first window begins, and the columns in front of luma.
        scratch: the kept products, and where those of each tap begin; a row weighed vertically; its even and
            then its odd columns; where those of each tap begin; the tensor.
    """
    products, row_starts, narrow, halves, column_starts, tensor = scratch
    taps, total, bottom = products.shape[0], 3 * products.shape[2], luma.shape[0] - 1
    begun = first[0] + rows[0] * step
    for row in range(rows[0], rows[1]):
        end = first[0] + row * step + taps
        for last in range(begun, end):
            above, below = luma[min(max(last, 0), bottom)], luma[min(max(last + 1, 0), bottom)]
            _multiply(above, above[1:], below, below[1:], first[1], products[last % taps])
        begun = end
        for tap in range(taps):
            row_starts[tap] = (end + tap) % taps * total
        for pair in range(0, weights.size, len(pairs)):
            _weigh(flat_products, row_starts, weights, pair, pairs, narrow[:total])
        if step == 2:
            _part(narrow, halves[: total // 2], halves[total // 2 :])
        for pair in range(0, weights.size, len(pairs)):
            _weigh(narrow if step == 1 else halves, column_starts, weights, pair, pairs, flat_sums)
        _quantize(tensor, bins, selected[row])


@compiled(fastmath=True, noalias=True)
def _multiply(above, above_right, below, below_right, before, products):  # type: ignore[no-untyped-def]
    """Squares and product of the differences along both diagonals, between four pixels each.

    Beyond the border, which is repeated, the differences are those between its two pixels.
    """
    half, inside = np.float32(0.5), above_right.size
    falls, mixed, rises = products[0], products[1], products[2]
    for x in range(inside):
        falling, rising = below_right[x] - above[x], above_right[x] - below[x]
        falls[before:][x] = half * falling * falling
        mixed[before:][x] = half * falling * rising
        rises[before:][x] = half * rising * rising
    for first, last, column in ((0, before, 0), (before + inside, falls.size, inside)):
        falling = below[column] - above[column]
        square = half * falling * falling
        for x in range(first, last):
            falls[x], mixed[x], rises[x] = square, -square, square


@compiled(fastmath=True, noalias=True)
def _weigh(numbers, starts, weights, pair, pairs, out):  # type: ignore[no-untyped-def]
    """Add some weighted pairs of taps to a total, or start it with the first ones.

    Args:
        starts: uint64, where the numbers of each tap begin.
    """
    one, other = starts[pair:], starts[starts.size - pair - len(pairs) :]
    for x in range(out.size):
        right = np.uint64(x)
        total = weights[pair] * (numbers[one[0] + right] + numbers[other[len(pairs) - 1] + right])
        for tap in range(1, len(pairs)):
            both = numbers[one[tap] + right] + numbers[other[len(pairs) - 1 - tap] + right]
            total += weights[pair + tap] * both
        out[x] = total if pair == 0 else out[x] + total


@compiled(fastmath=True, noalias=True)
def _part(row, even, odd):  # type: ignore[no-untyped-def]
    for x in range(even.size):
        even[x], odd[x] = row[2 * x], row[2 * x + 1]


@compiled(fastmath=True, noalias=True)
def _quantize(tensor, bins, selected):  # type: ignore[no-untyped-def]
    """The bins of a row. In the rotated axes of the differences, gx^2 - gy^2 is 2 b and 2 gx gy is a - c."""
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    orientations, strengths, coherences = bins[0], bins[1], bins[2]
    per_turn = orientations * np.float32(1 / (2 * math.pi))
    pi, straight = np.float32(math.pi), np.float32(math.pi / 2)
    least, last = np.float32(EPSILON), np.int32(orientations * strengths * coherences) - 1
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
        # Whole numbers as floats: vectors multiply them in half the time.
        orientation = np.floor(angle * per_turn + half)
        orientation = orientation + orientations if orientation < zero else orientation
        level = np.floor(min(max((strength - bins[3]) * bins[4], zero), strengths - half))
        clearness = np.floor(min(max((coherence - bins[5]) * bins[6], zero), coherences - half))
        selected[x] = index_at((orientation * strengths + level) * coherences + clearness, last)
