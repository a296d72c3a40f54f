"""Least-squares training: find for each bin the filter that is closest to the reference filter.

Paper, section 5.2, equations 4 and 5, with the eight symmetries of the training pictures. The unknowns are
defined in `vidstyle.blade.symmetry`. By construction, a constant picture stays constant, unless filters are
affine: then their sums and a constant for each are unknowns, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from vidstyle.blade.bins import Bins
from vidstyle.blade.choice import choice_radius, choose_filters
from vidstyle.blade.inference import RESAMPLING_METHOD
from vidstyle.blade.symmetry import pixel_pairs, symmetrize
from vidstyle.core.kernels import compiled
from vidstyle.core.resample import resample, scaled_shape

STRIPE_COUNT = 8
"""Parts of a picture that are summed separately; fixed, so that results do not depend on the number of
cores."""


@dataclass(frozen=True)
class TrainingConfig:
    """The shape of a bank and the regularization of its training.

    Attributes:
        bins, rho, size: see `Bank`.
        sums: the sum of the filters of each part: 1 if a constant is kept, 0 if it vanishes.
        smoothness: weight of the regularizer, the squared differences of neighbouring coefficients,
            relative to the mean energy of a bin's samples.
        scale: working size of the bank relative to the picture, 0..1; it is trained on reduced pictures.
        prior_samples: weight, in samples, of the average over all bins of the same orientation in each
            bin: it keeps rare bins from fitting noise, and empty bins behave like the average.
        affine: whether each filter has its own sum and a constant; then `sums` have no effect.
        planes: number of planes that filters are learned for together; each has its own constants.
        clips: limits of clipped differences, in levels of 255; see `vidstyle.blade.clipped`.
    """

    bins: Bins
    rho: float
    size: int
    sums: tuple[float, ...] = (1,)
    smoothness: float = 1e-4
    prior_samples: float = 50.0
    scale: float = 1.0
    affine: bool = False
    planes: int = 1
    clips: tuple[float, ...] = ()

    @property
    def linear_unknowns(self) -> int:
        """Number of unknown weights of unclipped pairs of opposite pixels, one or two per pair."""
        return len(pixel_pairs(self.size)) * (2 if self.bins.curvatures > 1 else 1)

    @property
    def pair_unknowns(self) -> int:
        """Number of unknown weights of pairs of opposite pixels; see `symmetry`."""
        return self.linear_unknowns + len(self.clips) * len(pixel_pairs(self.size))

    @property
    def unknowns(self) -> int:
        """Number of unknowns of a filter: weights of pairs, and if affine of the middle, and constants."""
        return self.pair_unknowns + (1 + self.planes if self.affine else 0)


@dataclass
class NormalEquations:
    """The normal equations of each bin, summed over the samples so far.

    Attributes:
        matrices: bins x unknowns x unknowns.
        vectors: bins x parts x unknowns.
        energies: bins x parts, sums of squared targets.
        samples: number of samples in each bin.
    """

    matrices: np.ndarray
    vectors: np.ndarray
    energies: np.ndarray
    samples: np.ndarray

    @classmethod
    def empty(cls, config: TrainingConfig) -> NormalEquations:
        count, parts, unknowns = config.bins.count, len(config.sums), config.unknowns
        return cls(
            np.zeros((count, unknowns, unknowns)),
            np.zeros((count, parts, unknowns)),
            np.zeros((count, parts)),
            np.zeros(count, np.int64),
        )

    def add(self, other: NormalEquations) -> None:
        for mine, theirs in zip(self.arrays, other.arrays, strict=True):
            mine += theirs

    @property
    def arrays(self) -> tuple[np.ndarray, ...]:
        return self.matrices, self.vectors, self.energies, self.samples


def accumulate(
    config: TrainingConfig,
    luma: np.ndarray,
    targets: Sequence[np.ndarray],
    pool: Executor,
    plane: np.ndarray | None = None,
    number: int = 0,
) -> NormalEquations:
    """Compute the normal equations of one picture.

    Args:
        luma: H x W float32 0..1.
        targets: the target of each part, H x W; pixels near the border are ignored. Luma and targets have
            the full size, independent of the scale.
        pool: runs the stripes of the picture in parallel.
        plane: the plane to filter if it is not luma; luma then only selects the filters.
        number: the number of the plane among `config.planes`.
    """
    margin = max(config.size // 2, choice_radius(config.bins, config.rho)) + 1
    height, width = shape = scaled_shape(luma.shape, config.scale)
    luma = resample(luma, shape, RESAMPLING_METHOD)
    plane = luma if plane is None else resample(plane, shape, RESAMPLING_METHOD)
    targets = [before_enlarging(target, shape) for target in targets]
    total = NormalEquations.empty(config)
    if min(height, width) <= 2 * margin:
        return total
    chosen, step = choose_filters(luma, config.bins, config.rho), config.bins.pitch
    selected = chosen if step == 1 else np.kron(chosen, np.ones((step, step), np.int32))
    known = (0.0,) * len(targets) if config.affine else config.sums
    wanted = np.stack(
        [target - constant * plane for target, constant in zip(targets, known, strict=True)]
    ).astype(np.float32)
    offsets = np.array(pixel_pairs(config.size), np.int64)
    edges = np.linspace(margin, height - margin, STRIPE_COUNT + 1).astype(int)

    def run(stripe: int) -> NormalEquations:
        sums = NormalEquations.empty(config)
        rows = int(edges[stripe]), int(edges[stripe + 1])
        regressors = np.zeros(config.unknowns)
        if config.affine:
            regressors[config.pair_unknowns + 1 + number] = 1
        clips = np.array(config.clips, np.float32) / 255
        ends = config.linear_unknowns, config.pair_unknowns
        _sum_up(plane, wanted, selected, offsets, margin, rows, regressors, ends, clips, *sums.arrays)
        return sums

    for sums in pool.map(run, range(STRIPE_COUNT)):
        total.add(sums)
    return total


def with_sums(config: TrainingConfig, sums: NormalEquations) -> tuple[TrainingConfig, NormalEquations]:
    """Return the configuration and equations of filters with the sums of `config`, from affine ones."""
    middle = config.pair_unknowns
    known = np.array(config.sums, np.float64)[:, None]
    vectors = sums.vectors - known * sums.matrices[:, None, middle]
    energies = sums.energies - known[:, 0] * (sums.vectors + vectors)[..., middle]
    found = NormalEquations(sums.matrices[:, :middle, :middle], vectors[..., :middle], energies, sums.samples)
    return replace(config, affine=False), found


def with_gains(config: TrainingConfig, sums: NormalEquations) -> TrainingConfig:
    """Return the configuration with the sums that are best for affine equations.

    One filter and one sum for all bins: a sum alone would also absorb the effect of smoothing.
    """
    count = config.pair_unknowns + 1
    matrix = sums.matrices[:, :count, :count].sum(axis=0)
    matrix += 1e-9 * (np.trace(matrix) + 1e-12) / count * np.eye(count)
    gains = np.linalg.solve(matrix, sums.vectors[..., :count].sum(axis=0).T)[-1]
    return replace(config, sums=tuple(map(float, gains)))


def before_enlarging(target: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return the smaller picture that is closest to the target when enlarged like the result."""
    if target.shape == shape:
        return target
    rows, columns = map(_inverse_of_enlarging, shape, target.shape)
    return np.asarray(rows @ target @ columns.T, np.float32)


@lru_cache(maxsize=64)
def _inverse_of_enlarging(small: int, large: int) -> np.ndarray:
    """Return the pseudoinverse of enlarging along one axis: small x large float64."""
    enlarging = resample(np.eye(small, dtype=np.float32), (large, small), RESAMPLING_METHOD).astype(float)
    return np.linalg.solve(enlarging.T @ enlarging, enlarging.T)


def solve_weights(config: TrainingConfig, sums: NormalEquations) -> np.ndarray:
    """Return the unknowns: parts x bins x unknowns."""
    unknowns = sums.matrices.shape[1]
    # The numbers of samples are summed over the symmetries like an additional part.
    counts = np.broadcast_to(sums.samples[:, None, None], (len(sums.samples), 1, unknowns))
    summed = np.concatenate([sums.vectors, counts], axis=1)
    matrices, summed = symmetrize(sums.matrices, summed, config.bins, config.size, len(config.clips))
    vectors, samples = summed[:, :-1], summed[:, -1, 0]
    matrices, vectors = _with_prior(config, matrices, vectors, samples)
    smooth, bend = _regularizer(config)
    # Relative to the energy of each bin: a weight for strong edges would turn flat areas into a box blur.
    energy = _energies(config, matrices)
    weight = config.smoothness * energy[:, :1, None]
    # Where all differences are small, clipped and unclipped ones are equal.
    ridge = (1e-6 if config.clips else 1e-9) * energy[:, _groups(config), None] * np.eye(unknowns)
    regular = matrices + config.smoothness * np.tensordot(energy, smooth, 1) + ridge
    found = np.linalg.solve(regular, (vectors + weight * bend).transpose(0, 2, 1))
    return found.transpose(2, 0, 1)


def _groups(config: TrainingConfig) -> np.ndarray:
    """Return the group of each unknown: 0 for unclipped pairs and affine ones, then one for each clip."""
    pairs = len(pixel_pairs(config.size))
    of_pairs = [0] * config.linear_unknowns + [
        1 + clip for clip in range(len(config.clips)) for _ in range(pairs)
    ]
    return np.array(of_pairs + [0] * (config.unknowns - config.pair_unknowns))


def _energies(config: TrainingConfig, matrices: np.ndarray) -> np.ndarray:
    """Return the mean energy of the regressors of pairs in each group: bins x groups."""
    squares = np.diagonal(matrices, axis1=1, axis2=2)[:, : config.pair_unknowns]
    groups = _groups(config)[: config.pair_unknowns]
    return (
        np.stack([squares[:, groups == each].mean(axis=1) for each in range(1 + len(config.clips))], 1)
        + 1e-12
    )


def squared_errors(sums: NormalEquations, weights: np.ndarray) -> np.ndarray:
    """Return the sum of squared errors of each part and bin for these unknowns."""
    mixed = np.einsum("pbi,bpi->pb", weights, sums.vectors)
    squared = np.einsum("pbi,bij,pbj->pb", weights, sums.matrices, weights)
    return np.asarray(sums.energies.T - 2 * mixed + squared)


def _with_prior(
    config: TrainingConfig, matrices: np.ndarray, vectors: np.ndarray, samples: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Add a prior to the equations: the average over bins of the same orientation and over all bins."""
    in_family = samples.reshape(config.bins.orientations, -1).sum(1)
    results = []
    for sums in (matrices, vectors):
        of_all = sums.sum(0) / max(samples.sum(), 1)
        families = sums.reshape(config.bins.orientations, -1, *sums.shape[1:]).sum(1)
        families = (families + of_all) / (in_family + 1)[:, None, None]
        shared = np.repeat(families, config.bins.count // config.bins.orientations, axis=0)
        results.append(
            (sums + config.prior_samples * shared) / (samples + config.prior_samples)[:, None, None]
        )
    return results[0], results[1]


def _regularizer(config: TrainingConfig) -> tuple[np.ndarray, np.ndarray]:
    """Return the squared slopes of the coefficients: a matrix for each group, and a linear part."""
    impulse = np.zeros((config.size, config.size, 1))
    impulse[config.size // 2, config.size // 2] = 1
    from_weights, from_middle = map(_slopes, (_coefficients_of_weights(config), impulse))
    known = np.zeros(len(config.sums)) if config.affine else config.sums
    slopes = [from_weights, *map(_slopes, _coefficients_of_clipped(config))]
    return np.stack([each.T @ each for each in slopes]), -np.outer(known, from_weights.T @ from_middle)


def _slopes(filters: np.ndarray) -> np.ndarray:
    """Return the differences of neighbouring coefficients of filters, size x size x unknowns, in rows."""
    return np.concatenate([np.diff(filters, axis=axis).reshape(-1, filters.shape[2]) for axis in (0, 1)])


def _coefficients_of_weights(config: TrainingConfig) -> np.ndarray:
    """Return the filter of each unknown, size x size x unknowns.

    The filter of a pair's sum has 1 at both pixels and -2 in the middle; the filter of its difference has 1
    and -1. The weight of the middle is the sum of the filter; a constant is no part of it.
    """
    pairs, radius = pixel_pairs(config.size), config.size // 2
    matrix = np.zeros((config.size, config.size, config.unknowns))
    for number in range(config.linear_unknowns):
        down, right = pairs[number % len(pairs)]
        is_sum = number < len(pairs)
        matrix[radius + down, radius + right, number] = 1
        matrix[radius - down, radius - right, number] = 1 if is_sum else -1
        matrix[radius, radius, number] = -2 if is_sum else 0
    if config.affine:
        matrix[radius, radius, config.pair_unknowns] = 1
    return matrix


def _coefficients_of_clipped(config: TrainingConfig) -> np.ndarray:
    """Return the weights of clipped differences of each unknown, clips x size x size x unknowns."""
    pairs, radius = pixel_pairs(config.size), config.size // 2
    images = np.zeros((len(config.clips), config.size, config.size, config.unknowns))
    for clip, image in enumerate(images):
        for number, (down, right) in enumerate(pairs, config.linear_unknowns + clip * len(pairs)):
            image[radius + down, radius + right, number] = image[radius - down, radius - right, number] = 1
    return images


def as_filters(config: TrainingConfig, weights: np.ndarray) -> np.ndarray:
    """Return the filters of unknowns: parts x bins x size x size float32."""
    filters = np.tensordot(weights, _coefficients_of_weights(config), (2, 2))
    if not config.affine:
        middle = config.size // 2
        filters[:, :, middle, middle] += np.array(config.sums)[:, None]
    return filters.astype(np.float32)


def clipped_of(config: TrainingConfig, weights: np.ndarray) -> np.ndarray | None:
    """Return the weights of clipped differences: parts x bins x clips x size x size; None without clips."""
    if not config.clips:
        return None
    return np.tensordot(weights, _coefficients_of_clipped(config), (2, 3)).astype(np.float32)


def constants_of(config: TrainingConfig, weights: np.ndarray) -> np.ndarray | None:
    """Return the constants of unknowns: parts x bins x planes float32; None if they are not affine."""
    return weights[..., config.pair_unknowns + 1 :].astype(np.float32) if config.affine else None


@compiled(fastmath=True)
def _sum_up(  # type: ignore[no-untyped-def]
    luma,
    wanted,
    selected,
    offsets,
    margin,
    rows,
    differences,
    ends,
    clips,
    matrices,
    vectors,
    energies,
    samples,
):
    """Add the equations of some rows.

    Args:
        ends: the numbers of unknowns that are weights of unclipped pairs, and of all pairs.
        differences: filled with the regressors of a pixel; constants are set by the caller.
    """
    unknowns, pairs, parts, (linear, end) = len(differences), len(offsets), len(wanted), ends
    for row in range(rows[0], rows[1]):
        for column in range(margin, luma.shape[1] - margin):
            number, middle = selected[row, column], luma[row, column]
            for k in range(pairs):
                down, right = offsets[k, 0], offsets[k, 1]
                one, other = luma[row + down, column + right], luma[row - down, column - right]
                differences[k] = one + other - middle - middle
                if linear > pairs:
                    differences[pairs + k] = one - other
                for place in range(len(clips)):
                    clip = clips[place]
                    differences[linear + place * pairs + k] = min(max(one - middle, -clip), clip) + min(
                        max(other - middle, -clip), clip
                    )
            if unknowns > end:
                differences[end] = middle
            samples[number] += 1
            for k in range(unknowns):
                for j in range(k, unknowns):
                    matrices[number, k, j] += differences[k] * differences[j]
            for part in range(parts):
                target = np.float64(wanted[part, row, column])
                energies[number, part] += target * target
                for k in range(unknowns):
                    vectors[number, part, k] += target * differences[k]
    # Only the upper triangle was summed.
    for number in range(matrices.shape[0]):
        for k in range(unknowns):
            for j in range(k):
                matrices[number, k, j] = matrices[number, j, k]
