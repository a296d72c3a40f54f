"""Clipped differences: weights by which a bank treats small and large differences of pixels differently.

A linear filter adds w (z - m) for each pixel z around the middle pixel m. A bank with clips also adds
v min(max(z - m, -t), t) for each clip t, so that pixels beyond an edge count little, as in a bilateral or
median filter. This is an addition to the paper.
"""

from __future__ import annotations

import numpy as np

from vidstyle.blade.clipped_simd import add_clipped_block, clipped_sum
from vidstyle.core.kernels import compiled
from vidstyle.core.kernels.vectors import VECTOR_LANES


def add_clipped(
    out: np.ndarray,
    luma: np.ndarray,
    first: int,
    selected: np.ndarray,
    packed: np.ndarray,
    size: int,
    clips: tuple[float, ...],
) -> None:
    """Add to each pixel of `out` the weighted clipped differences around it.

    Args:
        out: rows x W float32.
        luma: H x W float32; beyond its border the border is repeated.
        first: the row of luma of the first row of `out`.
        selected: the filter of each pixel of `out`, int32.
        packed: from `pack_clipped`.
        size: rows and columns of a filter.
        clips: the clips, in levels of 255.
    """
    radius, right = size // 2, size % 2 + VECTOR_LANES + size
    padded = np.pad(luma, ((radius, radius), (radius, right)), mode="edge")
    sides = (0,) * size, (0,) * len(clips)
    _add(padded[first:], selected, packed, np.array(clips, np.float32) / 255, sides, out)


@compiled(fastmath=True)
def _add(padded, selected, packed, clips, sides, out):  # type: ignore[no-untyped-def]
    """Add the weighted clipped differences of all pixels.

    Args:
        padded: luma with its border.
        sides: two tuples whose lengths are the rows of a filter, and the clips.
    """
    whole = out.shape[1] - out.shape[1] % VECTOR_LANES
    for row in range(out.shape[0]):
        lines, chosen, result = padded[row:], selected[row], out[row]
        for column in range(0, whole, VECTOR_LANES):
            add_clipped_block(packed, chosen, lines, column, sides, clips, result)
        for x in range(whole, out.shape[1]):
            result[x] += clipped_sum(packed[chosen[x]], lines, x, sides, clips)
