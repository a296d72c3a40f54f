"""White noise: random numbers that are fixed to the points of an endless lattice."""

from __future__ import annotations

import numpy as np

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
