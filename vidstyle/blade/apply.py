"""Runs a bank over a picture on the CPU."""

from __future__ import annotations

import numpy as np

from vidstyle.blade.features import LANES, repeated
from vidstyle.blade.vectors import eight_pixels
from vidstyle.core.kernels import compiled


def padded_filters(filters: np.ndarray) -> np.ndarray:
    """Filters, count x size x size, as float32 with rows padded by zeros for vector registers."""
    count, size, _ = filters.shape
    padded = np.zeros((count, size, -(-size // LANES) * LANES), np.float32)
    padded[:, :, :size] = filters
    return padded


def apply_filters(
    luma: np.ndarray, chosen: np.ndarray, padded: np.ndarray, margin: tuple[int, int] = (0, 0)
) -> np.ndarray:
    """Each pixel filtered with the filter that was chosen for it.

    Args:
        luma: H x W float32; beyond its border the border is repeated.
        chosen: H x W int32, the number of each pixel's filter.
        padded: from `padded_filters`.
        margin: how many of the first and last rows are not needed.

    Returns:
        H x W float32, new; what is in the rows of the margin means nothing.
    """
    height, width = luma.shape
    size, whole = padded.shape[1], -(-width // LANES) * LANES
    around = repeated(luma, size // 2, whole - width + padded.shape[2] + LANES)
    out = np.empty((height, whole), np.float32)
    _apply(around, _widened(chosen, whole), padded, (0,) * size, margin[0], height - margin[1], out)
    return out[:, :width]


def _widened(chosen: np.ndarray, whole: int) -> np.ndarray:
    """The numbers with so many columns: those that `choose_filters` has kept beyond them, or a copy."""
    if chosen.base is not None and chosen.base.shape == (len(chosen), whole):
        return chosen.base
    widened = np.zeros((len(chosen), whole), np.int32)
    widened[:, : chosen.shape[1]] = chosen
    return widened


@compiled(fastmath=True)
def _apply(around, chosen, filters, rows, top, bottom, out):  # type: ignore[no-untyped-def]
    for row in range(top, bottom):
        for column in range(0, out.shape[1], 8):
            eight_pixels(filters, chosen[row], around, row, column, rows, out[row])
