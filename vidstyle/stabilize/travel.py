"""Marks that move with the objects of a film: their drift, followed from frame to frame.

Marks near each other move together, so that they keep their shapes and distances: each anchor moves with the
picture and carries the marks around it. Anchors end where they crowd, and begin where they thin out, with the
drift that is already there.
"""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import compiled
from vidstyle.core.picture import Picture
from vidstyle.stabilize.flow import flow_grid
from vidstyle.stabilize.motion import Warp, reduced_shape

ANCHOR_CELLS = 4
"""Distance of anchors in the first frame of a scene, in cells of the grid of the flow."""
MAX_BIN_ANCHORS = 6
"""Most anchors in a square of this side."""
MIN_OWNED_CELLS = 2
"""An anchor that carries the marks of fewer cells ends."""
MOTION_SPREAD_CELLS, MOTION_SPREAD_RATIO = 0.2, 0.1
"""Difference of motion that counts as much as a distance of `ANCHOR_CELLS`: at least, and relative to it."""
REST_COST = 0.5
"""Cost of carrying marks that rest by an anchor that moves, and the reverse."""
MAX_COST = 1.2
"""Cells that differ more from all anchors, in squared distances, get an anchor."""
X, Y, RIGHT, DOWN, FLOW_X, FLOW_Y = range(6)
"""The numbers of an anchor: its place, its drift, and its last motion, in cells."""
ENDED_PLACE_CELLS = -1e6
"""Place of an anchor that has ended."""


class DriftFollower:
    """The drift of the marks of a film; see `core.drift`."""

    def __init__(self) -> None:
        self._anchors = np.empty((0, 6), np.float32)
        self._drift = np.empty((0, 0, 2), np.float32)

    def memory(self) -> list[np.ndarray]:
        """Return the anchors and the drift after the previous frame."""
        return [self._anchors, self._drift]

    def follow(self, picture: Picture, warp: Warp | None) -> np.ndarray | None:
        """Return the drift in the next frame of a film; None where no mark has moved.

        Args:
            warp: of the previous frame into this one; None if a scene begins.
        """
        height, width = picture.shape
        columns, rows = flow_grid(reduced_shape(picture.shape), width)
        if warp is None or self._drift.shape[:2] != (rows, columns):
            self._anchors, self._drift = (
                _first_anchors(rows, columns),
                np.zeros((rows, columns, 2), np.float32),
            )
        elif warp.marks_flow is not None:
            size = np.array([columns, rows], np.float32)
            self._move(warp.marks_flow * (size / np.array([width, height], np.float32)))
        if not self._drift.any():
            return None
        return self._drift / np.array([columns, rows], np.float32)

    def _move(self, flow: np.ndarray) -> None:
        rows, columns = flow.shape[:2]
        bins = -(-rows // ANCHOR_CELLS), -(-columns // ANCHOR_CELLS)
        anchors, before, drift = self._anchors.copy(), self._drift, np.empty_like(self._drift)
        counts, members = np.zeros(bins, np.int32), np.empty((*bins, MAX_BIN_ANCHORS), np.int32)
        _move_anchors(anchors, flow, counts, members)
        _carry_marks(anchors, flow, counts, members, np.zeros(len(anchors), np.int32), before, drift)
        self._anchors, self._drift = anchors, drift


def _first_anchors(rows: int, columns: int) -> np.ndarray:
    """Return anchors on a square grid, with room for the same number again."""
    half = ANCHOR_CELLS / 2
    y, x = np.mgrid[half : rows + half : ANCHOR_CELLS, half : columns + half : ANCHOR_CELLS]
    anchors = np.zeros((2 * x.size, 6), np.float32)
    anchors[: x.size, X], anchors[: x.size, Y], anchors[x.size :, X] = x.ravel(), y.ravel(), ENDED_PLACE_CELLS
    return anchors


@compiled
def _mean_flow(flow, x, y):  # type: ignore[no-untyped-def]
    """Return the mean of the flow around a place, 5 x 5 cells: to the right, and down."""
    right, down, count = np.float32(0), np.float32(0), np.float32(0)
    row = min(max(int(np.floor(y)), 0), flow.shape[0] - 1)
    column = min(max(int(np.floor(x)), 0), flow.shape[1] - 1)
    if flow[row, column, 0] == 0 and flow[row, column, 1] == 0:  # it rests, also next to moving objects
        return right, down
    for i in range(max(row - 2, 0), min(row + 3, flow.shape[0])):
        for j in range(max(column - 2, 0), min(column + 3, flow.shape[1])):
            right += flow[i, j, 0]
            down += flow[i, j, 1]
            count += np.float32(1)
    return right / count, down / count


@compiled
def _move_anchors(anchors, flow, counts, members):  # type: ignore[no-untyped-def]
    """Move anchors to where they are now, and sort them into bins; end those outside and in full bins."""
    for k in range(anchors.shape[0]):
        x, y = anchors[k, X], anchors[k, Y]
        if x > ENDED_PLACE_CELLS:
            right, down = _mean_flow(flow, x, y)
            right, down = _mean_flow(flow, x - right, y - down)  # it is known at the new place
            x, y = x - right, y - down
            row, column = int(np.floor(y / ANCHOR_CELLS)), int(np.floor(x / ANCHOR_CELLS))
            is_inside = 0 <= row < counts.shape[0] and 0 <= column < counts.shape[1]
            anchors[k, X] = ENDED_PLACE_CELLS
            if is_inside and counts[row, column] < MAX_BIN_ANCHORS:
                anchors[k, X], anchors[k, Y] = x, y
                anchors[k, RIGHT] -= right
                anchors[k, DOWN] -= down
                anchors[k, FLOW_X], anchors[k, FLOW_Y] = right, down
                members[row, column, counts[row, column]] = k
                counts[row, column] += 1


@compiled
def _nearest_anchor(anchors, counts, members, x, y, right, down):  # type: ignore[no-untyped-def]
    """Return the anchor that is nearest in place and motion, or -1, and its cost."""
    best, least = -1, np.float32(1e9)
    across, motion = np.float32(1 / ANCHOR_CELLS**2), np.float32(MOTION_SPREAD_CELLS)
    motion += np.float32(MOTION_SPREAD_RATIO) * (abs(right) + abs(down))
    row, column = int(y) // ANCHOR_CELLS, int(x) // ANCHOR_CELLS
    for i in range(max(row - 1, 0), min(row + 2, counts.shape[0])):
        for j in range(max(column - 1, 0), min(column + 2, counts.shape[1])):
            for n in range(counts[i, j]):
                k = members[i, j, n]
                dx, dy = anchors[k, X] - x, anchors[k, Y] - y
                other, under = anchors[k, FLOW_X] - right, anchors[k, FLOW_Y] - down
                own, others = right == 0 and down == 0, anchors[k, FLOW_X] == 0 and anchors[k, FLOW_Y] == 0
                cost = np.float32(0 if own == others else REST_COST)
                cost += across * (dx * dx + dy * dy) + (other * other + under * under) / (motion * motion)
                if cost < least:
                    best, least = k, cost
    return best, least


@compiled
def _carry_marks(anchors, flow, counts, members, owned, before, drift):  # type: ignore[no-untyped-def]
    """Give each cell the drift of its anchor; add missing anchors, and end those with few cells."""
    rows, columns = drift.shape[:2]
    unused, half = 0, np.float32(0.5)
    for row in range(rows):
        for column in range(columns):
            x, y = np.float32(column) + half, np.float32(row) + half
            right, down = flow[row, column, 0], flow[row, column, 1]
            best, cost = _nearest_anchor(anchors, counts, members, x, y, right, down)
            i, j = row // ANCHOR_CELLS, column // ANCHOR_CELLS
            while unused < anchors.shape[0] and anchors[unused, X] > ENDED_PLACE_CELLS:
                unused += 1
            if cost > MAX_COST and counts[i, j] < MAX_BIN_ANCHORS and unused < anchors.shape[0]:
                best = unused
                from_row = min(max(int(np.floor(y + down)), 0), rows - 1)
                from_column = min(max(int(np.floor(x + right)), 0), columns - 1)
                anchors[best, X], anchors[best, Y] = x, y
                anchors[best, RIGHT] = before[from_row, from_column, 0] - right
                anchors[best, DOWN] = before[from_row, from_column, 1] - down
                anchors[best, FLOW_X], anchors[best, FLOW_Y] = right, down
                members[i, j, counts[i, j]] = best
                counts[i, j] += 1
            drift[row, column, 0], drift[row, column, 1] = np.float32(0), np.float32(0)
            if best >= 0:
                drift[row, column, 0], drift[row, column, 1] = anchors[best, RIGHT], anchors[best, DOWN]
                owned[best] += 1
    for k in range(anchors.shape[0]):
        if owned[k] < MIN_OWNED_CELLS:
            anchors[k, X] = ENDED_PLACE_CELLS
