"""The eight symmetries of a square, applied to filters and bins.

A rotated or mirrored picture selects the rotated or mirrored filters, since bins of orientation are centred
on multiples of their width and windows on the pixel. The sums over a picture therefore determine the sums
over its seven images (paper, section 5.2) without visiting them.

The unknowns of a filter are one weight for each pair of opposite pixels: the weight of their sum minus twice
the middle. Rotated by 180 degrees, a straight line and its filter stay the same; a curved line bends the
other way. If bins depend on curvature, each pair has a second weight, for the difference of its pixels. A
bank with clipped differences has a further weight of each pair for each clip. The last unknowns of affine
filters, the weight of the middle and constants, are the same in all images.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from vidstyle.blade.bins import Bins


@dataclass(frozen=True)
class Symmetry:
    """A rotation or reflection: x' = a x + b y, y' = c x + d y.

    Attributes:
        matrix: (a, b), (c, d).
    """

    matrix: tuple[tuple[int, int], tuple[int, int]]

    def moved(self, down: int, right: int) -> tuple[int, int]:
        """Return the image of a pixel, as rows down and columns right of the middle."""
        (a, b), (c, d) = self.matrix
        return c * right + d * down, a * right + b * down

    def bin_of(self, bins: Bins, number: int) -> int:
        """Return the image of a bin."""
        orientation, clearness, curvature, feature = np.unravel_index(number, _sides(bins))
        (a, b), (c, d) = self.matrix
        mirrored = a * d - b * c < 0
        turned = (bins.orientations // 2) * [(1, 0), (0, 1), (-1, 0), (0, -1)].index((a, c))
        turns, orientation = divmod(turned + (-orientation if mirrored else orientation), bins.orientations)
        if turns % 2:  # the line is reversed
            curvature = bins.curvatures - 1 - curvature
        return int(np.ravel_multi_index((orientation, clearness, curvature, feature), _sides(bins)))


SYMMETRIES = tuple(
    Symmetry(matrix) for x in (1, -1) for y in (1, -1) for matrix in (((x, 0), (0, y)), ((0, x), (y, 0)))
)
"""All eight. A rotation by 180 degrees changes no orientation."""


def _sides(bins: Bins) -> tuple[int, int, int, int]:
    """Return the numbers of bins of orientation, strength x coherence, curvature, and additional features."""
    clearnesses = bins.strengths * bins.coherences
    before = bins.orientations * clearnesses * bins.curvatures
    return bins.orientations, clearnesses, bins.curvatures, bins.count // before


def pixel_pairs(size: int) -> list[tuple[int, int]]:
    """List one pixel, as rows down and columns right of the middle, of each pair symmetric about the middle.

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


def pair_weights(filters: np.ndarray, has_differences: bool) -> np.ndarray:
    """Return the weights of pairs, parts x bins x unknowns, of filters, parts x bins x size x size.

    Args:
        has_differences: whether weights of differences follow; otherwise filters must be symmetric about the
            middle.
    """
    radius = filters.shape[2] // 2
    one, other = (
        np.stack(
            [
                filters[:, :, radius + sign * down, radius + sign * right]
                for down, right in pixel_pairs(filters.shape[2])
            ],
            axis=-1,
        ).astype(np.float64)
        for sign in (1, -1)
    )
    return np.concatenate([(one + other) / 2, (one - other) / 2], axis=-1) if has_differences else one


def symmetrize(
    matrices: np.ndarray, vectors: np.ndarray, bins: Bins, size: int, clip_count: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Add to the sums over samples the sums over the seven images of each sample.

    Args:
        matrices: bins x unknowns x unknowns.
        vectors: bins x parts x unknowns.
        clip_count: number of clips of the differences.
    """
    all_matrices, all_vectors = np.zeros_like(matrices), np.zeros_like(vectors)
    for symmetry in SYMMETRIES:
        order, signs = _images_of_unknowns(symmetry, size, bins.curvatures > 1, clip_count, matrices.shape[1])
        # Reading in the order of the images is many times as fast as writing to them.
        source, unknowns = np.argsort(_images_of_bins(symmetry, bins)), np.argsort(order)
        pairs = (unknowns[:, None] * len(order) + unknowns).ravel()
        flat = (np.outer(signs, signs) * matrices).reshape(len(matrices), -1)
        all_matrices += flat.take(source, axis=0).take(pairs, axis=1).reshape(matrices.shape)
        all_vectors += (signs * vectors).take(source, axis=0).take(unknowns, axis=2)
    return all_matrices, all_vectors


@cache
def _images_of_bins(symmetry: Symmetry, bins: Bins) -> np.ndarray:
    """Return the image of each bin."""
    return np.array([symmetry.bin_of(bins, number) for number in range(bins.count)])


def _images_of_unknowns(
    symmetry: Symmetry, size: int, has_differences: bool, clip_count: int, unknowns: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the index of the image of each unknown, and -1 if its difference changes sign."""
    pairs = pixel_pairs(size)
    images = [symmetry.moved(*pixel) for pixel in pairs]
    order = [pairs.index(image if image in pairs else (-image[0], -image[1])) for image in images]
    signs = [1] * len(pairs)
    if has_differences:
        signs += [1 if image in pairs else -1 for image in images]
    groups = 1 + has_differences + clip_count
    order = [number * len(pairs) + each for number in range(groups) for each in order]
    others = range(len(order), unknowns)
    return np.array([*order, *others]), np.array([*signs, *[1] * (unknowns - len(signs))])
