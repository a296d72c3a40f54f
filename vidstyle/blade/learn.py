"""Learns a bank: for each bin the filter that comes closest to what is to be imitated.

Least squares on pairs of pixels (paper, section 5.2, equation 5, with its regularizer): with the eight
symmetries every filter is symmetric about its middle, so that the unknowns are one weight for each pair of
opposite pixels, of the difference between the pair and the middle. A constant then stays a constant by
construction, whatever is learned.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from vidstyle.blade.features import Bins, choose_filters, window_radius
from vidstyle.blade.symmetry import as_weights, folded, pairs
from vidstyle.core.kernels import compiled

STRIPES = 8
"""A picture is summed up in so many parts, always the same, so that the number of cores changes no digit."""


@dataclass(frozen=True)
class TrainingConfig:
    """What is to be learned.

    Attributes:
        bins, rho, size: of the bank.
        sums: for each part, what its filters add up to: 1 where a constant stays, 0 where it vanishes.
        smoothness: weight of the regularizer, the squared differences of neighbouring coefficients,
            against the mean energy of a bin's samples.
        kinship: how many samples of all its kin, the bins of the same orientation, a bin is given, so that
            a rare one does not learn noise and an empty one behaves like them.
    """

    bins: Bins
    rho: float
    size: int
    sums: tuple[int, ...] = (1,)
    smoothness: float = 1e-4
    kinship: float = 50.0


@dataclass
class Sums:
    """What has been learned from so far: normal equations for each bin.

    Attributes:
        matrices: bins x pairs x pairs.
        vectors: bins x parts x pairs.
        energies: bins x parts, the squared targets.
        samples: how many for each bin.
    """

    matrices: np.ndarray
    vectors: np.ndarray
    energies: np.ndarray
    samples: np.ndarray

    @classmethod
    def empty(cls, lesson: TrainingConfig) -> Sums:
        """Nothing yet."""
        count, parts, unknowns = lesson.bins.count, len(lesson.sums), len(pairs(lesson.size))
        return cls(
            np.zeros((count, unknowns, unknowns)),
            np.zeros((count, parts, unknowns)),
            np.zeros((count, parts)),
            np.zeros(count, np.int64),
        )

    def add(self, other: Sums) -> None:
        """Learn from what another one has seen."""
        self.matrices += other.matrices
        self.vectors += other.vectors
        self.energies += other.energies
        self.samples += other.samples


def look_at(lesson: TrainingConfig, luma: np.ndarray, targets: Sequence[np.ndarray], pool: Executor) -> Sums:
    """The sums of one picture.

    Args:
        luma: H x W float32 0..1.
        targets: what each part is to make of it, H x W; pixels near the border are left out.
        pool: runs the parts of the picture side by side.
    """
    margin = max(lesson.size // 2, window_radius(lesson.rho)) + 1
    height, width = luma.shape
    total = Sums.empty(lesson)
    if min(height, width) <= 2 * margin:
        return total
    chosen = choose_filters(luma, lesson.bins, lesson.rho)
    wanted = np.stack(
        [target - constant * luma for target, constant in zip(targets, lesson.sums, strict=True)]
    ).astype(np.float32)
    offsets = np.array(pairs(lesson.size), np.int64)
    edges = np.linspace(margin, height - margin, STRIPES + 1).astype(int)

    def run(stripe: int) -> Sums:
        sums = Sums.empty(lesson)
        rows = edges[stripe], edges[stripe + 1]
        _sum_up(
            luma,
            wanted,
            chosen,
            offsets,
            margin,
            rows,
            sums.matrices,
            sums.vectors,
            sums.energies,
            sums.samples,
        )
        return sums

    for sums in pool.map(run, range(STRIPES)):
        total.add(sums)
    return total


def solve(lesson: TrainingConfig, sums: Sums) -> np.ndarray:
    """The filters: parts x bins x size x size float32."""
    matrices, vectors = folded(sums.matrices, sums.vectors, lesson.bins, lesson.size)
    samples = _folded_samples(lesson, sums.samples)
    matrices, vectors = _with_kin(lesson, matrices, vectors, samples)
    smooth, bend = _regularizer(lesson)
    # Each bin by its own energy: what is right for strong edges would make flat places a box blur.
    energy = np.trace(matrices, axis1=1, axis2=2)[:, None, None] / matrices.shape[1] + 1e-12
    weight, ridge = lesson.smoothness * energy, 1e-9 * energy * np.eye(matrices.shape[1])
    found = np.linalg.solve(matrices + weight * smooth + ridge, (vectors + weight * bend).transpose(0, 2, 1))
    return _as_filters(lesson, found.transpose(2, 0, 1))


def residuals(lesson: TrainingConfig, sums: Sums, filters: np.ndarray) -> np.ndarray:
    """The mean squared error of each part and bin on the samples themselves; NaN for empty bins."""
    weights = as_weights(filters, lesson.size)
    with np.errstate(invalid="ignore"):
        return np.stack(
            [
                (
                    sums.energies[:, part]
                    - 2 * np.einsum("bi,bi->b", weights[part], sums.vectors[:, part])
                    + np.einsum("bi,bij,bj->b", weights[part], sums.matrices, weights[part])
                )
                / sums.samples
                for part in range(len(filters))
            ]
        )


def _folded_samples(lesson: TrainingConfig, samples: np.ndarray) -> np.ndarray:
    nothing = np.zeros((len(samples), 0, len(pairs(lesson.size))))
    counted = np.broadcast_to(samples[:, None, None], (len(samples), *[len(pairs(lesson.size))] * 2))
    return folded(counted.astype(float), nothing, lesson.bins, lesson.size)[0][:, 0, 0]


def _with_kin(
    lesson: TrainingConfig, matrices: np.ndarray, vectors: np.ndarray, samples: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The equations with some of those of all bins of the same orientation, and of all bins, added."""
    kin = samples.reshape(lesson.bins.orientations, -1).sum(1)
    results = []
    for sums in (matrices, vectors):
        of_all = sums.sum(0) / max(samples.sum(), 1)
        families = sums.reshape(lesson.bins.orientations, -1, *sums.shape[1:]).sum(1)
        families = (families + of_all) / (kin + 1)[:, None, None]
        shared = np.repeat(families, lesson.bins.count // lesson.bins.orientations, axis=0)
        results.append((sums + lesson.kinship * shared) / (samples + lesson.kinship)[:, None, None])
    return results[0], results[1]


def _regularizer(lesson: TrainingConfig) -> tuple[np.ndarray, np.ndarray]:
    """The squared differences of neighbouring coefficients: a matrix on the weights, and a linear part."""
    size = lesson.size
    index = np.arange(size * size).reshape(size, size)
    steps = np.concatenate(
        [
            np.stack([one.ravel(), other.ravel()], axis=1)
            for one, other in ((index[1:], index[:-1]), (index[:, 1:], index[:, :-1]))
        ]
    )
    differences = np.zeros((len(steps), size * size))
    differences[np.arange(len(steps)), steps[:, 0]] = 1
    differences[np.arange(len(steps)), steps[:, 1]] = -1
    from_weights = differences @ _spread(size)
    middle = differences[:, index[size // 2, size // 2]]
    bend = -np.outer(lesson.sums, from_weights.T @ middle)
    return from_weights.T @ from_weights, bend


def _spread(size: int) -> np.ndarray:
    """What a weight adds to each coefficient: 1 at both pixels of its pair, -2 in the middle."""
    matrix = np.zeros((size, size, len(pairs(size))))
    radius = size // 2
    for number, (down, right) in enumerate(pairs(size)):
        matrix[radius + down, radius + right, number] = 1
        matrix[radius - down, radius - right, number] = 1
        matrix[radius, radius, number] = -2
    return matrix.reshape(size * size, -1)


def _as_filters(lesson: TrainingConfig, weights: np.ndarray) -> np.ndarray:
    size = lesson.size
    filters = (weights @ _spread(size).T).reshape(*weights.shape[:2], size, size)
    filters[:, :, size // 2, size // 2] += np.array(lesson.sums)[:, None]
    return filters.astype(np.float32)


@compiled(fastmath=True)
def _sum_up(luma, wanted, chosen, offsets, margin, rows, matrices, vectors, energies, samples):  # type: ignore[no-untyped-def]
    unknowns, parts = len(offsets), len(wanted)
    differences = np.empty(unknowns)
    for row in range(rows[0], rows[1]):
        for column in range(margin, luma.shape[1] - margin):
            number, middle = chosen[row, column], luma[row, column]
            for k in range(unknowns):
                down, right = offsets[k, 0], offsets[k, 1]
                there = luma[row + down, column + right] + luma[row - down, column - right]
                differences[k] = there - middle - middle
            samples[number] += 1
            for k in range(unknowns):
                for j in range(k, unknowns):
                    matrices[number, k, j] += differences[k] * differences[j]
            for part in range(parts):
                target = np.float64(wanted[part, row, column])
                energies[number, part] += target * target
                for k in range(unknowns):
                    vectors[number, part, k] += target * differences[k]
    # Only the upper half was summed up.
    for number in range(matrices.shape[0]):
        for k in range(unknowns):
            for j in range(k):
                matrices[number, k, j] = matrices[number, j, k]
