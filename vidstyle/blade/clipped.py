"""Clipped differences: weights by which a bank treats small and large differences of pixels differently.

A linear filter adds w (z - m) for each pixel z around the middle pixel m. A bank with clips also adds
v min(max(z - m, -t), t) for each clip t, so that pixels beyond an edge count little, as in a bilateral or
median filter. This is an addition to the paper.
"""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.core.kernels.vectors import VECTOR_LANES


def pack_clipped(weights: np.ndarray) -> np.ndarray:
    """Pack weights, bins x clips x size x size, for `add_clipped`: bins x size x clips x whole vectors."""
    size = weights.shape[-1]
    rows = np.pad(weights.transpose(0, 2, 1, 3), [(0, 0)] * 3 + [(0, -size % VECTOR_LANES)])
    return np.ascontiguousarray(rows, np.float32)


def add_clipped(
    out: np.ndarray,
    luma: np.ndarray,
    first: int,
    selected: np.ndarray,
    packed: np.ndarray,
    clips: tuple[float, ...],
) -> None:
    """Add to each pixel of `out` the weighted clipped differences around it.

    Args:
        out: rows x W float32.
        luma: H x W float32; beyond its border the border is repeated.
        first: the row of luma of the first row of `out`.
        selected: the filter of each pixel of `out`, int32.
        packed: from `pack_clipped`.
        clips: the clips, in levels of 255.
    """
    size, width = packed.shape[1], packed.shape[3]
    radius = size // 2
    padded = np.pad(luma, ((radius, radius), (radius, radius + width - size)), mode="edge")
    sides = (0,) * size, (0,) * len(clips), (0,) * width
    _add(padded[first:], selected, packed, np.array(clips, np.float32) / 255, sides, out)


@compiled(fastmath=True, noalias=True)
def _add(padded, selected, packed, clips, sides, out):  # type: ignore[no-untyped-def]
    """Add the weighted clipped differences, row by row of the filters: 15 to 60 % faster than whole filters.

    Args:
        padded: luma with its border.
        sides: three tuples whose lengths are the rows of a filter, the clips, and the numbers of a row.
    """
    size, count, width = len(sides[0]), len(sides[1]), len(sides[2])
    for row in range(out.shape[0]):
        middles, chosen, result = padded[row + size // 2], selected[row], out[row]
        for down in range(size):
            line = padded[row + down]
            for x in range(out.shape[1]):
                weights, window = packed[chosen[x], down], line[x : x + width]
                middle, total = middles[x + size // 2], np.float32(0)
                for number in range(count):
                    clip, of_clip = clips[number], weights[number]
                    for i in range(width):
                        total += of_clip[i] * min(max(window[i] - middle, -clip), clip)
                result[x] += total
