"""Arrays that begin with a line of the cache; those of NumPy begin anywhere."""

from __future__ import annotations

import math

import numpy as np

CACHE_LINE = 64
"""Bytes of a line of the cache, and of the longest vectors: one across the end of a line is loaded twice."""


def aligned_empty(shape: tuple[int, ...]) -> np.ndarray:
    """A new float32 array."""
    size = 4 * math.prod(shape)
    memory = np.empty(size + CACHE_LINE, np.uint8)
    start = -memory.__array_interface__["data"][0] % CACHE_LINE
    return memory[start : start + size].view(np.float32).reshape(shape)


def aligned(array: np.ndarray) -> np.ndarray:
    """A copy of an array of 32-bit numbers."""
    copy = aligned_empty(array.shape).view(array.dtype)
    copy[:] = array
    return copy
