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
def _random(bits):  # type: ignore[no-untyped-def]
    """The number of `white_noise` for a point, whose column and row are mixed in `bits`.

    In 32 bits, cut to them after each step: Numba makes 64 of them, of which the compiler makes half as many
    numbers in a vector.
    """
    bits = np.uint32(np.uint32(bits ^ (bits >> np.uint32(15))) * np.uint32(0x2C1B3C6D))
    bits = np.uint32(np.uint32(bits ^ (bits >> np.uint32(12))) * np.uint32(0x297A2D39))
    return np.float32(np.int32(np.uint32(bits ^ (bits >> np.uint32(15))) >> np.uint32(8))) * np.float32(
        2.0**-24
    )


@compiled
def noise_between(x, y):  # type: ignore[no-untyped-def]
    """Noise between the points of the lattice of `white_noise`; x and y are not negative."""
    column, row = np.int32(x), np.int32(y)
    beside, below = x - np.float32(column), y - np.float32(row)
    left = np.uint32(np.uint32(column) * np.uint32(0x9E3779B1))
    upper = np.uint32(np.uint32(row) * np.uint32(0x85EBCA77))
    right, lower = np.uint32(left + np.uint32(0x9E3779B1)), np.uint32(upper + np.uint32(0x85EBCA77))
    first, second = _random(np.uint32(left ^ upper)), _random(np.uint32(right ^ upper))
    above = first + beside * (second - first)
    first, second = _random(np.uint32(left ^ lower)), _random(np.uint32(right ^ lower))
    return above + below * (first + beside * (second - first) - above)
