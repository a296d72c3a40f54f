"""What blocks that draw strokes share: where strokes lead, and random numbers that are fixed to the page."""

from __future__ import annotations

import math

import numpy as np

from vidstyle.core.kernels import compiled

APART = 10007
"""Rows between what two drawings take of the noise."""
STILL = 0.06
"""Strength of the fixed direction beside that of edges: it decides where there are none."""


def stroke_directions(flow: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """The unit vector along the edge at each pixel: to the right and down, H x W float32 each.

    Args:
        flow: the smoothed result of the block `structure_tensor`.
        angle: the direction where there are no edges, in degrees.
    """
    turn = math.radians(-2 * angle)  # in the picture, y points down
    fixed = np.array(
        [STILL * math.cos(turn), STILL * math.sin(turn), math.cos(turn), math.sin(turn)], np.float32
    )
    out = np.empty((2, *flow.shape[:2]), np.float32)
    _halve_angles(flow.reshape(-1, 3), fixed, out.reshape(2, -1))
    return out[0], out[1]


@compiled
def _halve_angles(flow, fixed, out):  # type: ignore[no-untyped-def]
    half, one, two, most = np.float32(0.5), np.float32(1), np.float32(2), np.float32(16)
    for i in range(out.shape[1]):
        # Minus: along the edge, a right angle from the gradient.
        x, y = fixed[0] - (two * flow[i, 0] - one), fixed[1] - (two * flow[i, 1] - one)
        # Infinite or NaN, it would lead anywhere: what is no direction is the fixed one.
        usable = abs(x) + abs(y) < most
        x, y = x if usable else fixed[2], y if usable else fixed[3]
        scale = one / max(np.sqrt(x * x + y * y), np.float32(1e-12))
        cosine, sine = x * scale, y * scale
        # Half the angle: the longer part by its root, the other, which would lose digits so, by a product.
        longer = np.sqrt(half + half * abs(cosine))
        shorter = abs(sine) / (two * longer)
        out[0, i] = shorter if cosine < 0 else longer
        out[1, i] = math.copysign(longer if cosine < 0 else shorter, y)


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
