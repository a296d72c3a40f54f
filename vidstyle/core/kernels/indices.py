"""From numbers to indices: values on a border, beyond the ends, and indices that vectors of look-ups take."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels.declare import compiled

TIE_LIFT = np.float32(5e-5)
"""Added to a value before it is compared with the border between two tones, so that ties go to the upper one.

Many values lie exactly on a border: 8-bit codes, and middle gray wherever a difference is zero. Rounding of a
matrix, or of a GPU's 16-bit textures, which is up to 2.3e-5, must not decide there."""


@compiled
def index_at(place, last):  # type: ignore[no-untyped-def]
    """The whole part of a place as an index, 0..last, int32.

    Compared after the cast: NaN passes comparisons of floats where the compiler may assume there is none.
    """
    return min(max(np.int32(place), np.int32(0)), np.int32(last))


@compiled
def look_up_at(index):  # type: ignore[no-untyped-def]
    """An index in 32 bits that cannot be negative: with others the compiler makes no vectors of look-ups."""
    return np.uint32(max(np.int32(index), np.int32(0)))
