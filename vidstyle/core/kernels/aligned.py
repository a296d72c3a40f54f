"""Arrays aligned to cache lines; NumPy does not align its arrays."""

from __future__ import annotations

import math
from itertools import accumulate, pairwise

import numpy as np

CACHE_LINE_BYTES = 64
"""Bytes of a cache line, and of the longest vectors: a vector across two lines is loaded twice."""
CACHE_LINE_FLOATS = CACHE_LINE_BYTES // 4
"""Numbers of 32 bits in a line."""


def round_up(number: int, multiple: int) -> int:
    """Return the least multiple that is not below a number.

    >>> round_up(17, 16)
    32
    """
    return -(-number // multiple) * multiple


def aligned_empty(shape: tuple[int, ...]) -> np.ndarray:
    """Return a new float32 array."""
    size = 4 * math.prod(shape)
    memory = np.empty(size + CACHE_LINE_BYTES, np.uint8)
    start = -memory.__array_interface__["data"][0] % CACHE_LINE_BYTES
    return memory[start : start + size].view(np.float32).reshape(shape)


def aligned(array: np.ndarray) -> np.ndarray:
    """Return a copy of an array of 32-bit numbers."""
    copy = aligned_empty(array.shape).view(array.dtype)
    copy[:] = array
    return copy


def aligned_parts(*shapes: tuple[int, ...]) -> tuple[np.ndarray, ...]:
    """Several new float32 arrays in one piece of memory, which takes less time than one for each."""
    lines = (round_up(math.prod(shape), CACHE_LINE_FLOATS) for shape in shapes)
    starts = list(accumulate(lines, initial=0))
    memory = aligned_empty((starts[-1],))
    places = zip(shapes, pairwise(starts), strict=True)
    return tuple(memory[slice(*place)][: math.prod(shape)].reshape(shape) for shape, place in places)
