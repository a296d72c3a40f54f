"""The eight symmetries of a square, applied to filters and bins.

A rotated or mirrored picture selects the rotated or mirrored filters, since bins of orientation are centred
on multiples of their width and windows on the pixel. So the sums over a picture give those over its seven
images (paper, section 5.2) without visiting them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vidstyle.blade.structure_tensor import Bins


@dataclass(frozen=True)
class Symmetry:
    """A rotation or reflection: x' = a x + b y, y' = c x + d y.

    Attributes:
        matrix: (a, b), (c, d).
    """

    matrix: tuple[tuple[int, int], tuple[int, int]]

    def moved(self, down: int, right: int) -> tuple[int, int]:
        """The image of a pixel, as rows down and columns right of the middle."""
        (a, b), (c, d) = self.matrix
        return c * right + d * down, a * right + b * down

    def bin_of(self, bins: Bins, number: int) -> int:
        """The image of a bin."""
        rest = bins.count // bins.orientations
        orientation = number // rest
        (a, b), (c, d) = self.matrix
        mirrored = a * d - b * c < 0
        turned = bins.orientations // 2 if a == 0 else 0
        orientation = (turned + (-orientation if mirrored else orientation)) % bins.orientations
        return orientation * rest + number % rest


SYMMETRIES = tuple(
    Symmetry(matrix) for x in (1, -1) for y in (1, -1) for matrix in (((x, 0), (0, y)), ((0, x), (y, 0)))
)
"""All eight. A rotation by 180 degrees changes no orientation."""


def pixel_pairs(size: int) -> list[tuple[int, int]]:
    """One pixel, as rows down and columns right of the middle, of each pair symmetric about the middle.

    >>> pixel_pairs(3)
    [(0, 1), (1, -1), (1, 0), (1, 1)]
    """
    radius = size // 2
    return [
        (down, right)
        for down in range(radius + 1)
        for right in range(-radius, radius + 1)
        if down > 0 or right > 0
    ]


def pair_weights(filters: np.ndarray, size: int) -> np.ndarray:
    """The weight of each pair: parts x bins x pairs, of parts x bins x size x size symmetric filters."""
    radius = size // 2
    return np.stack(
        [filters[:, :, radius + down, radius + right] for down, right in pixel_pairs(size)], axis=-1
    ).astype(np.float64)


def symmetrized(
    matrices: np.ndarray, vectors: np.ndarray, bins: Bins, size: int
) -> tuple[np.ndarray, np.ndarray]:
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
    """For each pair the index of its image."""
    pairs = pixel_pairs(size)
    images = (symmetry.moved(*pixel) for pixel in pairs)
    return [
        pairs.index((down, right) if (down, right) in pairs else (-down, -right)) for down, right in images
    ]
