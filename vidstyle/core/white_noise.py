"""White noise: random numbers that are fixed to the points of an endless lattice."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled

APART = 10007
"""Points between the parts of the lattice that two drawings, or two octaves, take."""


def white_noise(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Uniform random numbers 0..1 for the points of a lattice that runs on for ever.

    Args:
        rows, columns: of the points, whole numbers.

    Returns:
        rows x columns float32, the same for the same point.
    """
    bits = (columns.astype(np.uint32) * np.uint32(0x9E3779B1))[None] ^ (
        rows.astype(np.uint32) * np.uint32(0x85EBCA77)
    )[:, None]
    for shift, factor in ((15, 0x2C1B3C6D), (12, 0x297A2D39)):
        bits = (bits ^ (bits >> np.uint32(shift))) * np.uint32(factor)
    return ((bits ^ (bits >> np.uint32(15))) >> np.uint32(8)).astype(np.float32) * np.float32(2.0**-24)


@compiled
def _random(x, y):  # type: ignore[no-untyped-def]
    """The number of `white_noise` for one point."""
    most = np.uint64(0xFFFFFFFF)
    bits = ((np.uint64(x) * np.uint64(0x9E3779B1)) ^ (np.uint64(y) * np.uint64(0x85EBCA77))) & most
    bits = ((bits ^ (bits >> np.uint64(15))) * np.uint64(0x2C1B3C6D)) & most
    bits = ((bits ^ (bits >> np.uint64(12))) * np.uint64(0x297A2D39)) & most
    return np.float32((bits ^ (bits >> np.uint64(15))) >> np.uint64(8)) * np.float32(2.0**-24)


@compiled
def noise_between(x, y):  # type: ignore[no-untyped-def]
    """Noise between the points of the lattice of `white_noise`; x and y are not negative."""
    column, row = int(x), int(y)
    beside, below = x - np.float32(column), y - np.float32(row)
    first, second = _random(column, row), _random(column + 1, row)
    upper = first + beside * (second - first)
    first, second = _random(column, row + 1), _random(column + 1, row + 1)
    return upper + below * (first + beside * (second - first) - upper)
