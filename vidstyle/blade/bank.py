"""A bank of learned filters; `bank_file` reads and writes it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from vidstyle.blade.before.local_mode import MAX_EXPONENT, MAX_MODE_RADIUS
from vidstyle.blade.before.percentile_curve import MAX_LEVEL
from vidstyle.blade.bins import Bins
from vidstyle.blade.symmetry import pair_weights

FILTER_SIZES = range(3, 16, 2)
"""The allowed filter sizes in pixels."""
MAX_FILTERS = 1024
"""Maximum number of filters in a part: their numbers are stored in 16-bit textures."""
MAX_RHO = 8
"""Maximum standard deviation of the tensor's window, in pixels: shaders hold 16 of its weights."""
MAX_SLIDERS = 3
"""Maximum number of weights that a bank declares as sliders."""
MAX_FEATURES = 2
"""Maximum number of additional features by which a bank's filters are selected."""
MAX_CLIPS = 3
"""Maximum number of clips of the differences of a bank."""
MAX_WEIGHT = 1024.0
"""Maximum weight of a pixel; weights of trained banks are below 1."""


@dataclass(frozen=True)
class Bank:
    """Learned filters, and the quantization of the features by which they are selected.

    Attributes:
        bins: quantization of the structure tensor's features; each bin has one filter per part.
        rho: standard deviation of the structure tensor's window, in pixels.
        filters: parts x bins x size x size float32. The result is the weighted sum of the parts; a
            block sets the weights.
        chroma: filters of the same shape for the two chroma planes; None if these stay unchanged.
        constants: parts x bins x planes float32, added to the results of the filters of luma, or of luma and
            both chroma planes. None for a bank in which all filters of a part have the same sum, so that flat
            areas stay flat, and filters are symmetric about the middle or bins depend on curvature.
        clips: limits of differences from the middle pixel, in levels of 255; see `vidstyle.blade.clipped`.
        clipped: parts x bins x clips x size x size float32, weights of clipped differences of luma, symmetric
            about the middle; None without clips.
        next: the bank of the second stage, which filters the result; None for a bank of one stage.
        matrix: 3 x 4 float32, colour matrix applied to RGB 0..1 before the filters, whose last column is
            added; the result is clipped to 0..1. None for a bank that reads only luma.
        curve: percentages and levels of a `percentile_curve` of luma before the filters, 4 x 2 float32, or
            2 x 2 for a straight line between two percentiles; None without.
        mode: radius and exponent, int32, of a `local_mode` of luma before the filters, or None.
        scale: working size relative to the picture, 0..1.
        about: a record of the training, as plain data: "imitates" (the reference filter), "parts" (names),
            "pictures" (names and checksums), "samples" and "residuals" (in levels of 255) of each filter,
            "sliders" and others.
    """

    bins: Bins
    rho: float
    filters: np.ndarray
    about: dict[str, Any] = field(default_factory=dict)
    chroma: np.ndarray | None = None
    constants: np.ndarray | None = None
    scale: float = 1
    clips: tuple[float, ...] = ()
    clipped: np.ndarray | None = None
    next: Bank | None = None
    matrix: np.ndarray | None = None
    curve: np.ndarray | None = None
    mode: np.ndarray | None = None

    def __post_init__(self) -> None:
        problem = _problem(self)
        if problem:
            raise ValueError(problem)

    @property
    def size(self) -> int:
        """Rows and columns of a filter."""
        return int(self.filters.shape[2])

    @cached_property
    def stages(self) -> tuple[Bank, ...]:
        """The bank of each stage."""
        return (self,) if self.next is None else (replace(self, next=None), *self.next.stages)

    @cached_property
    def of_chroma(self) -> Bank:
        """The bank that filters the chroma planes.

        Raises:
            ValueError: it has no filters for chroma.
        """
        if self.chroma is None:
            raise ValueError("has no filters for chroma")
        constants = None if self.constants is None else self.constants[..., 1:]
        of_luma = dict.fromkeys(("chroma", "clipped", "next", "matrix", "curve", "mode"))
        return replace(self, filters=self.chroma, constants=constants, clips=(), **of_luma)  # type: ignore[arg-type]

    @cached_property
    def packed(self) -> tuple[np.ndarray, ...]:
        """The weights of pairs of opposite pixels, one bins x texels x 4 float32 array per part.

        The weights of sums come first, then the weights of differences if bins depend on curvature or the
        bank has constants. Then a bank with constants has the sum of the filter and its constants for one or
        two planes. The weights of clipped differences come last.
        """
        has_differences = self.bins.curvatures > 1 or self.constants is not None
        weights = pair_weights(self.filters, has_differences)
        if self.constants is not None:
            lines = np.zeros((*weights.shape[:2], 4))
            lines[..., 0] = self.filters.sum(axis=(2, 3), dtype=np.float64)
            planes = min(self.constants.shape[2], 2)
            lines[..., 1 : 1 + planes] = self.constants[..., :planes]
            weights = np.concatenate([weights, lines], axis=2)
        for number in range(len(self.clips)):
            assert self.clipped is not None
            weights = np.concatenate([weights, pair_weights(self.clipped[:, :, number], False)], axis=2)
        return tuple(weights.astype(np.float32).reshape(*weights.shape[:2], -1, 4))

    @cached_property
    def packed_in_half(self) -> tuple[np.ndarray, ...]:
        """`packed` as half floats; the error is at most 1/4096 of a weight."""
        return tuple(part.astype(np.float16) for part in self.packed)

    @property
    def sliders(self) -> dict[str, tuple[float, float]]:
        """Names and ranges of the weights of the parts after the first, as declared by the bank."""
        return {name: (low, high) for name, low, high in self.about.get("sliders", [])}

    def weights_at(self, shares: Sequence[float]) -> tuple[float, ...]:
        """Return the weights of the parts with each slider at a share of its range; 1 for the first part.

        Parts without a slider have weight 0.
        """
        ends = zip(shares, self.sliders.values(), strict=False)
        found = [1.0, *(low + share * (high - low) for share, (low, high) in ends)]
        return (*found, *[0.0] * (len(self.filters) - len(found)))

    @property
    def sums(self) -> tuple[float, ...]:
        """The response of each part to a constant 1, its mean; 0 if each filter has its own sum."""
        if self.constants is not None:
            return (0.0,) * len(self.filters)
        return tuple(float(part.sum(axis=(1, 2)).mean()) for part in self.filters)

    def combined(self, weights: tuple[float, ...]) -> np.ndarray:
        """Return the weighted sum of the parts: bins x size x size float32.

        Raises:
            ValueError: the numbers of weights and parts differ.
        """
        if len(weights) != len(self.filters):
            raise ValueError(f"has {len(self.filters)} parts, not {len(weights)}")
        return np.tensordot(np.asarray(weights, np.float32), self.filters, 1)

    def combined_clipped(self, weights: tuple[float, ...]) -> np.ndarray | None:
        """Return the weighted sum of the parts' `clipped`: bins x clips x size x size float32, or None."""
        return None if self.clipped is None else np.tensordot(np.array(weights, np.float32), self.clipped, 1)

    def combined_constants(self, weights: tuple[float, ...]) -> np.ndarray | None:
        """Return the weighted sum of the parts' constants: bins x planes float32; None without constants."""
        return (
            None if self.constants is None else np.tensordot(np.array(weights, np.float32), self.constants, 1)
        )


def _problem(bank: Bank) -> str:
    """Return the defect of a bank, or an empty text."""
    for find_problem in (
        _problem_of_bins,
        _problem_of_filters,
        _problem_of_constants,
        _problem_of_clips,
        _problem_of_stages,
        _problem_of_matrix,
        _problem_of_luma_steps,
    ):
        if problem := find_problem(bank):
            return problem
    arrays = bank.filters, bank.chroma, bank.constants, bank.clipped, bank.matrix
    numbers = [each for each in arrays if each is not None]
    wrong = sum(each.size - np.count_nonzero(np.abs(each) <= MAX_WEIGHT) for each in numbers)
    return f"has {wrong} weights that are NaN or beyond {MAX_WEIGHT:g}" if wrong else ""


def _problem_of_bins(bank: Bank) -> str:
    """Return the defect of the bins and their window, or an empty text."""
    bins = bank.bins
    if not isinstance(bins.curvatures, int) or min(bins.counts) < 1 or bins.orientations % 2:
        return f"has bins {' x '.join(map(str, bins.counts))}; the number of orientations must be even"
    divided = bins.features or bins.curvatures > 1 or bank.constants is not None or bank.clips
    if not isinstance(bins.pitch, int) or bins.pitch not in (1, 2) or (bins.pitch > 1 and divided):
        allowed = "1 or, without features, constants or clips, 2"
        return f"shares filters in squares of {bins.pitch} pixels; allowed are {allowed}"
    if type(bank.scale) not in (int, float) or not 0 < bank.scale <= 1:
        return f"has a scale of {bank.scale!r}, which is not above 0 and at most 1"
    ends = (*bins.strength_range, *bins.coherence_range)
    if not (ends[0] < ends[1] and ends[2] < ends[3] and 0 < bank.rho <= MAX_RHO and bins.is_finite):
        return "has an empty range of bins, or a window of an invalid size"
    return ""


def _problem_of_filters(bank: Bank) -> str:
    """Return the defect of the filters for luma and chroma and of the sliders, or an empty text."""
    bins, filters = bank.bins, bank.filters
    if filters.dtype != np.float32 or filters.ndim != 4 or filters.shape[2] != filters.shape[3]:
        return (
            f"has filters of shape {filters.shape} and type {filters.dtype}, not parts x bins x size x size"
        )
    if filters.shape[2] not in FILTER_SIZES or not 1 <= len(filters) <= 8:
        return f"has {len(filters)} parts of {filters.shape[2]} x {filters.shape[2]} pixels"
    if filters.shape[1] != bins.count or bins.count > MAX_FILTERS:
        return f"has {filters.shape[1]} filters for {bins.count} bins; there are at most {MAX_FILTERS}"
    if not _are_sliders(bank.about.get("sliders", []), len(filters) - 1):
        return "declares sliders that are not [name, low, high] of a part after the first"
    if bank.chroma is not None and (bank.chroma.shape, bank.chroma.dtype) != (filters.shape, filters.dtype):
        return f"has filters for chroma of shape {bank.chroma.shape}, for luma of {filters.shape}"
    return ""


def _problem_of_constants(bank: Bank) -> str:
    """Return the defect of the constants that filters add, or an empty text."""
    constants, planes = bank.constants, (1, 2) if bank.chroma is None else (3,)
    if constants is None or (
        constants.dtype == np.float32
        and constants.shape[:-1] == bank.filters.shape[:2]
        and constants.shape[-1] in planes
    ):
        return ""
    return f"has constants of shape {constants.shape}, not parts x bins x planes"


def _problem_of_stages(bank: Bank) -> str:
    """Return the defect of the second stage, or an empty text."""
    if bank.next is None:
        return ""
    followers = bank.next.next, bank.next.chroma, bank.next.matrix, bank.next.curve, bank.next.mode
    if any(each is not None for each in followers) or len(bank.filters) + len(bank.next.filters) > 2:
        return "has a second stage with filters for chroma, earlier steps, several parts or a further stage"
    return "" if bank.next.scale == bank.scale else "has stages of different scales"


def _problem_of_matrix(bank: Bank) -> str:
    """Return the defect of the colour matrix of a bank, or an empty text."""
    matrix = bank.matrix
    if matrix is None or (matrix.shape == (3, 4) and matrix.dtype == np.float32):
        return ""
    return f"has a colour matrix of shape {matrix.shape} {matrix.dtype}, not (3, 4) float32"


def _problem_of_luma_steps(bank: Bank) -> str:
    """Return the defect of the steps that change luma before the filters, or an empty text."""
    curve, mode = bank.curve, bank.mode
    if curve is not None:
        if curve.shape not in ((2, 2), (4, 2)) or curve.dtype != np.float32:
            return f"has a tone curve of shape {curve.shape} {curve.dtype}, not (2 or 4, 2) float32"
        percentages, levels = curve.T
        ordered = (np.diff([0, *percentages, 100]) >= 0).all()
        if not (ordered and (np.abs(levels) <= MAX_LEVEL).all()):
            return (
                f"has a tone curve {curve.tolist()}, not increasing percentages and levels up to {MAX_LEVEL}"
            )
    if mode is not None:
        is_pair = mode.shape == (2,) and mode.dtype == np.int32
        if not (is_pair and 1 <= mode[0] <= MAX_MODE_RADIUS and 1 <= mode[1] <= MAX_EXPONENT):
            return f"has a local mode {mode.tolist()}, not a radius and an exponent of 1 to 8"
    return ""


def _problem_of_clips(bank: Bank) -> str:
    """Return the defect of the clips of a bank, or an empty text."""
    clips, clipped = bank.clips, bank.clipped
    if not (
        len(clips) <= MAX_CLIPS
        and all(type(each) in (int, float) and 0 < each <= 255 for each in clips)
        and list(clips) == sorted(set(clips))
    ):
        return f"has clips {clips!r}, not at most {MAX_CLIPS} increasing numbers above 0 and up to 255"
    shape = (*bank.filters.shape[:2], len(clips), *bank.filters.shape[2:])
    if not clips and clipped is None:
        return ""
    if clipped is None or clipped.shape != shape or clipped.dtype != np.float32:
        found = "none" if clipped is None else f"{clipped.shape} {clipped.dtype}"
        return f"has weights of clipped differences of shape {found}, not {shape} float32"
    symmetric = np.array_equal(clipped, clipped[..., ::-1, ::-1])
    return "" if symmetric else "has weights of clipped differences that are not symmetric about the middle"


def _are_sliders(declared: object, most: int) -> bool:
    """Whether sliders are declared as `Bank.sliders` expects, with valid weights of a filter."""
    return (
        isinstance(declared, list)
        and len(declared) <= min(most, MAX_SLIDERS)
        and all(
            isinstance(each, list)
            and len(each) == 3
            and isinstance(each[0], str)
            and all(type(end) in (int, float) and abs(end) <= MAX_WEIGHT for end in each[1:])
            for each in declared
        )
        and len({each[0] for each in declared}) == len(declared)
    )
