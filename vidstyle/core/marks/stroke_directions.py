"""Directions of strokes: along the edges, and a fixed direction in areas without edges."""

from __future__ import annotations

import math

import numpy as np

from vidstyle.core.kernels import compiled, interleaved

DEFAULT_ANGLE_STRENGTH = 0.06
"""Default strength of the fixed direction relative to edges: it matters only without edges."""


def stroke_directions(
    flow: np.ndarray, angle: float, strength: float = DEFAULT_ANGLE_STRENGTH
) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit vector along the edge at each pixel: to the right and down, H x W float32 each.

    Args:
        flow: the smoothed result of the block `structure_tensor`.
        angle: the direction in areas without edges, in degrees.
        strength: of this direction relative to edges.
    """
    turn = math.radians(-2 * angle)  # in the picture, y points down
    fixed = np.array(
        [strength * math.cos(turn), strength * math.sin(turn), math.cos(turn), math.sin(turn)], np.float32
    )
    out = np.empty((2, *flow.shape[:2]), np.float32)
    _halve_angles(interleaved(flow), fixed, *out)
    return out[0], out[1]


@compiled
def _halve_angles(flow, fixed, right, down):  # type: ignore[no-untyped-def]
    one, two, most = np.float32(1), np.float32(2), np.float32(16)
    for row in range(right.shape[0]):
        for i in range(right.shape[1]):
            # Minus: along the edge, a right angle from the gradient.
            x = fixed[0] - (two * flow[row, 3 * i] - one)
            y = fixed[1] - (two * flow[row, 3 * i + 1] - one)
            # An infinite or NaN direction is replaced by the fixed one.
            usable = abs(x) + abs(y) < most
            x, y = x if usable else fixed[2], y if usable else fixed[3]
            # Half the angle: the direction of the vector with its length added to its part across.
            length = max(np.sqrt(x * x + y * y), np.float32(1e-12))
            added = length + abs(x)
            scale = one / np.sqrt(two * length * added)
            longer, shorter = added * scale, abs(y) * scale
            right[row, i] = shorter if x < 0 else longer
            other = longer if x < 0 else shorter
            down[row, i] = -other if y < 0 else other
