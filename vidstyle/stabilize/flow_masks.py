"""Parts of a flow: where it is fast, and where it has borders."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled


def fast_part(flow: np.ndarray, least: float) -> np.ndarray | None:
    """Return the flow where its speed is at least `least`, and 0 elsewhere; None if it is slow everywhere.

    Args:
        flow: h x w x 2 float32.
    """
    part = np.empty_like(flow)
    _keep_fast(flow, np.float32(least), part)
    return part if part.any() else None


def border_guide(flow: np.ndarray, max_jump: float) -> np.ndarray:
    """Return 0 for cells that differ by more than `max_jump` from a neighbour, and for their neighbours.

    Args:
        flow: h x w x 2 float32.

    Returns:
        h x w x 1 float32; 1 for the other cells.
    """
    guide = np.ones((*flow.shape[:2], 1), np.float32)
    _clear_borders(flow, np.float32(max_jump), guide)
    return guide


@compiled
def _keep_fast(flow, least, part):  # type: ignore[no-untyped-def]
    for row in range(flow.shape[0]):
        for column in range(flow.shape[1]):
            across, down = flow[row, column, 0], flow[row, column, 1]
            is_slow = across * across + down * down < least * least
            part[row, column, 0] = np.float32(0) if is_slow else across
            part[row, column, 1] = np.float32(0) if is_slow else down


@compiled
def _clear_borders(flow, max_jump, guide):  # type: ignore[no-untyped-def]
    height, width = flow.shape[0], flow.shape[1]
    for row in range(height):
        for column in range(width):
            above, left = max(row - 1, 0), max(column - 1, 0)
            if _jump(flow, row, column, above, column) > max_jump or (
                _jump(flow, row, column, row, left) > max_jump
            ):
                for y in range(above, min(row + 2, height)):
                    for x in range(left, min(column + 2, width)):
                        guide[y, x, 0] = 0


@compiled
def _jump(flow, row, column, other_row, other_column):  # type: ignore[no-untyped-def]
    across = abs(flow[row, column, 0] - flow[other_row, other_column, 0])
    down = abs(flow[row, column, 1] - flow[other_row, other_column, 1])
    return max(across, down)
