"""Combs: rows that alternate between the two fields of an interlaced frame."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled

_MIN_COMB_LEVELS, _MAX_COMBED_SHARE = 10, 0.003
"""Minimum difference of neighbouring rows in a comb, and the share of pixels from which a frame is combed.

A walk with a camera has up to 0.0007, the same walk as interlaced fields from 0.014.
"""


def is_combed(luma: np.ndarray) -> bool:
    """Whether the rows of a frame, H x W uint8, alternate between two fields where something moves."""
    (height, width), found = luma.shape, np.zeros(1, np.int64)
    if height < 8:
        return False
    _count_comb_teeth(luma, np.zeros((2, width), np.int16), found)
    return int(found[0]) > _MAX_COMBED_SHARE * (height - 5) * width


@compiled
def _count_comb_teeth(luma, columns, found):  # type: ignore[no-untyped-def]
    """Count the pixels at the end of four rows that lie above and below their neighbours in turns.

    Args:
        columns: the direction of the last row, 1, -1 or 0, and the number of turns, at most 3; 2 x W.
    """
    count = 0
    for y in range(1, luma.shape[0] - 1):
        for x in range(luma.shape[1]):
            row, over, under = np.int16(luma[y, x]), np.int16(luma[y - 1, x]), np.int16(luma[y + 1, x])
            up, down = row - over, row - under
            depth = min(abs(up), abs(down))
            is_tooth = depth > _MIN_COMB_LEVELS and (up > 0) == (down > 0) and abs(over - under) < depth
            direction = np.int16(0)
            if is_tooth:
                direction = np.int16(1 if up > 0 else -1)
            turns = min(columns[1, x] + 1, 3) if direction * columns[0, x] < 0 else 0
            columns[0, x], columns[1, x] = direction, turns
            count += turns == 3
    found[0] = count
