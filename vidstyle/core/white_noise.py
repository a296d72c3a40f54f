"""White noise: random numbers that are fixed to the points of an endless lattice."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled

MAX_PAIR_CODE = 32767
"""The highest code of the numbers in a pair, so that their difference has 16 bits, too."""
LATTICE_PART_SIZE = 10007
"""Distance in points between the parts of the lattice that two drawings, or two octaves, use."""


def white_noise(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Uniform random numbers 0..1 for the points of a lattice that runs on for ever.

    Args:
        rows, columns: of the points, whole numbers.

    Returns:
        rows x columns float32, the same for the same point.
    """
    numbers = np.empty((rows.size, columns.size), np.float32)
    _hash(rows.astype(np.uint32), columns.astype(np.uint32), numbers)
    return numbers


@compiled
def _hash(rows, columns, numbers):  # type: ignore[no-untyped-def]
    for i in range(rows.size):
        for j in range(columns.size):
            numbers[i, j] = lattice_noise(rows[i], columns[j])


@compiled
def lattice_noise(row, column):  # type: ignore[no-untyped-def]
    """Return the number of one point, see `white_noise`."""
    bits = np.uint32(np.uint32(column) * np.uint32(0x9E3779B1)) ^ np.uint32(
        np.uint32(row) * np.uint32(0x85EBCA77)
    )
    bits = np.uint32((bits ^ (bits >> np.uint32(15))) * np.uint32(0x2C1B3C6D))
    bits = np.uint32((bits ^ (bits >> np.uint32(12))) * np.uint32(0x297A2D39))
    bits = np.uint32(bits ^ (bits >> np.uint32(15))) >> np.uint32(8)
    return np.float32(np.int32(bits)) * np.float32(2.0**-24)


def pairs_of(noise: np.ndarray) -> np.ndarray:
    """Return codes of numbers with the difference to the next column: n x (m - 1) int32.

    One look-up reads both; the codes are in the low halves.
    """
    codes = np.rint(noise * np.float32(MAX_PAIR_CODE)).astype(np.int32)
    return codes[:, :-1] | np.diff(codes, axis=1) << 16


@compiled(fastmath=True)
def between_pair(pair, right_weight):  # type: ignore[no-untyped-def]
    """Interpolate between the codes of a pair; `right_weight` is the weight of the right one."""
    left, more = np.float32(np.int32(pair & np.int32(0xFFFF))), np.float32(np.int32(pair >> np.int32(16)))
    return left + right_weight * more
