"""The eight symmetries of a square, acting on filters and on bins.

With bins of orientation that are centred on multiples of their width, and a window centred on the pixel, a
turned or mirrored picture chooses the turned or mirrored filters. So what is learned from one picture holds
for its seven images too, without looking at them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vidstyle.blade.features import Bins


@dataclass(frozen=True)
class Symmetry:
    """A turn or mirroring: x' = a x + b y, y' = c x + d y, and what becomes of a gradient's direction.

    Attributes:
        matrix: (a, b), (c, d).
    """

    matrix: tuple[tuple[int, int], tuple[int, int]]

    def moved(self, down: int, right: int) -> tuple[int, int]:
        """Where a pixel goes: rows down and columns right of the middle."""
        (a, b), (c, d) = self.matrix
        return c * right + d * down, a * right + b * down

    def bin_of(self, bins: Bins, number: int) -> int:
        """The bin that a bin becomes."""
        rest = bins.strengths * bins.coherences
        orientation = number // rest
        (a, b), (c, d) = self.matrix
        mirrored = a * d - b * c < 0
        turned = bins.orientations // 2 if a == 0 else 0
        orientation = (turned + (-orientation if mirrored else orientation)) % bins.orientations
        return orientation * rest + number % rest


SYMMETRIES = tuple(
    Symmetry(matrix) for x in (1, -1) for y in (1, -1) for matrix in (((x, 0), (0, y)), ((0, x), (y, 0)))
)
"""All eight; a turn by half changes no direction, since directions have a period of half a turn."""


def pairs(size: int) -> list[tuple[int, int]]:
    """One pixel, down and right, of each pair that lies symmetric about the middle of a filter.

    >>> pairs(3)
    [(0, 1), (1, -1), (1, 0), (1, 1)]
    """
    radius = size // 2
    return [
        (down, right)
        for down in range(radius + 1)
        for right in range(-radius, radius + 1)
        if down > 0 or right > 0
    ]


def as_weights(filters: np.ndarray, size: int) -> np.ndarray:
    """The weight of each pair: parts x bins x pairs, of parts x bins x size x size symmetric filters."""
    radius = size // 2
    return np.stack(
        [filters[:, :, radius + down, radius + right] for down, right in pairs(size)], axis=-1
    ).astype(np.float64)


def folded(matrices: np.ndarray, vectors: np.ndarray, bins: Bins, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Sums over samples, each with those of its seven images added.

    Args:
        matrices: bins x pairs x pairs.
        vectors: bins x parts x pairs.
    """
    all_matrices, all_vectors = np.zeros_like(matrices), np.zeros_like(vectors)
    for symmetry in SYMMETRIES:
        order = _order(symmetry, size)
        target = [symmetry.bin_of(bins, number) for number in range(bins.count)]
        all_matrices[np.ix_(target, order, order)] += matrices
        all_vectors[np.ix_(target, range(vectors.shape[1]), order)] += vectors
    return all_matrices, all_vectors


def _order(symmetry: Symmetry, size: int) -> list[int]:
    """For each pair the number of the pair that it becomes."""
    return list(_numbers(symmetry, pairs(size)))


def _numbers(symmetry: Symmetry, there: list[tuple[int, int]]) -> Iterator[int]:
    for pixel in there:
        down, right = symmetry.moved(*pixel)
        yield there.index((down, right) if (down, right) in there else (-down, -right))
