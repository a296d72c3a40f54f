"""The bins into which a bank sorts pixels by their local structure; each bin has its filter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

MIDDLE_CURVATURE = 0.12
"""Curvature of a line, in radians per pixel, in the middle of the bins of its sign."""


@dataclass(frozen=True)
class Feature:
    """An additional feature by which filters are selected.

    Attributes:
        name: "mean", the local mean of luma, a Gaussian; "difference", luma minus this mean; or "strength" or
            "coherence" as in `Bins`, of a tensor with a separate window.
        bins: the number of bins.
        rho: standard deviation of the window in pixels.
        ends: ends of the range of the uniform bins, in levels of 255 except for coherence; None for the
            default in `FEATURE_RANGES`.
    """

    name: str
    bins: int
    rho: float
    ends: tuple[float, float] | None = None

    @property
    def range(self) -> tuple[float, float]:
        """The ends of the range of its bins."""
        return FEATURE_RANGES[self.name] if self.ends is None else self.ends

    @property
    def needs_mean(self) -> bool:
        """Whether it is computed from the local mean, not from a tensor."""
        return self.name in ("mean", "difference")

    @property
    def start_and_density(self) -> tuple[np.float32, np.float32]:
        """Start of the bins of a mean or difference, 0..1, and number of bins per unit."""
        low, high = self.range
        return np.float32(low / 255), np.float32(255 * self.bins / (high - low))

    @property
    def tensor_bins(self) -> Bins:
        """Bins for this feature of a tensor only."""
        if self.name == "strength":
            return Bins(1, self.bins, 1, strength_range=self.range)
        return Bins(1, 1, self.bins, coherence_range=self.range)


FEATURE_RANGES = {
    "mean": (0.0, 255.0),
    "difference": (-30.0, 30.0),
    "strength": (10.0, 40.0),
    "coherence": (0.2, 0.8),
}
"""Names of features, and the default ranges of their bins."""


@dataclass(frozen=True)
class Bins:
    """The quantization of the features. Values outside a range belong to the bin at its end.

    Attributes:
        orientations: bins of the gradient's direction over half a turn, the first centred on "to the right".
        strengths: bins of the square root of the larger eigenvalue, in levels of 255 per pixel.
        coherences: bins of (a - b) / (a + b), where a and b are the roots of the two eigenvalues.
        strength_range, coherence_range: the ranges of the uniform bins.
        curvatures: bins of k / (|k| + `MIDDLE_CURVATURE`), where k is the signed curvature of the line in
            radians per pixel. If the number is odd, the middle bin is for straight lines.
        features: additional features, each of which divides every bin.
        pitch: side of the squares of pixels that share a filter: 1, or 2, which is four times as fast.
    """

    orientations: int = 24
    strengths: int = 1
    coherences: int = 3
    strength_range: tuple[float, float] = FEATURE_RANGES["strength"]
    coherence_range: tuple[float, float] = FEATURE_RANGES["coherence"]
    curvatures: int = 1
    features: tuple[Feature, ...] = ()
    pitch: int = 1

    @property
    def counts(self) -> tuple[int, int, int, int]:
        """The numbers of bins of the features of the structure tensor."""
        return self.orientations, self.strengths, self.coherences, self.curvatures

    @property
    def count(self) -> int:
        """The number of filters: `counts` x features, the last varying fastest."""
        return math.prod((*self.counts, *(each.bins for each in self.features)))

    def curvature_at(self, number: int) -> float:
        """Return the curvature in radians per pixel at which a bin of curvature begins."""
        share = 2 * number / self.curvatures - 1
        return (
            MIDDLE_CURVATURE * share / (1 - abs(share)) if abs(share) < 1 else math.copysign(math.inf, share)
        )

    @property
    def is_finite(self) -> bool:
        """Whether the ranges are finite, as kernels require."""
        arrays = (self.as_array, *(each.tensor_bins.as_array for each in self.features))
        return all(bool(np.isfinite(each).all()) for each in arrays)

    @cached_property
    def as_array(self) -> np.ndarray:
        """Return eight float32 for kernels: the counts, then start and bins per unit of both ranges."""
        low, high = self.strength_range
        first, last = self.coherence_range
        densities = 255 * self.strengths / (high - low), self.coherences / (last - first)
        with np.errstate(over="ignore"):
            return np.array([*self.counts, low / 255, densities[0], first, densities[1]], np.float32)
