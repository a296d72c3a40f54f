"""Arrays that vectors are loaded from."""

from __future__ import annotations

import numpy as np

ALIGNMENT = 64
"""Bytes of a cache line; vectors that lie in two of them take twice as long to load."""


def aligned(array: np.ndarray) -> np.ndarray:
    """A contiguous copy that begins at a cache line."""
    room = np.empty(array.nbytes + ALIGNMENT, np.uint8)
    first = -room.ctypes.data % ALIGNMENT
    copy = room[first : first + array.nbytes].view(array.dtype).reshape(array.shape)
    copy[:] = array
    return copy
