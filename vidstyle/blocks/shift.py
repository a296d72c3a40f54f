"""Shift: a plate out of register."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from vidstyle.block import REDRAW_RATE, Choice, FrameTime, LumaWeights, PageRegion, Slider, block, drawing_at
from vidstyle.blocks.noise import LATTICES, between_points, lattice_points
from vidstyle.core.kernels import compiled

PLATES = ("all", "red", "green", "blue", "chroma")


def _radius(y: float, x: float, jitter: float) -> int:
    return math.ceil(max(abs(y), abs(x) + jitter)) + 1


@block("filter", on="color", radius=_radius)
def shift(
    picture: np.ndarray,
    weights: LumaWeights,
    place: PageRegion,
    moment: FrameTime,
    plate: Annotated[str, Choice(PLATES, "what is moved; the rest stays")] = "chroma",
    x: Annotated[float, Slider(-64, 64, "to the right", "px", (-6, 6))] = 4,
    y: Annotated[float, Slider(-64, 64, "down", "px", (-4, 4))] = 0,
    jitter: Annotated[float, Slider(0, 64, "by how much rows sway to both sides at random", "px")] = 0,
    rate: Annotated[int, REDRAW_RATE] = 0,
) -> np.ndarray:
    """Move one channel, the chroma or the whole picture, as ink out of register or colour late on a tape.

    Fractions of a pixel are interpolated linearly; rows sway in waves three times as high as they are wide.
    The result is clipped to 0..1.
    """
    out = np.empty(picture.shape, np.float32)
    from_y = float(np.float32(-y))
    rows, parts = between_points(place.top, len(picture), np.float32(max(3 * jitter, 1)))
    lattice = drawing_at(moment, rate) * LATTICES + LATTICES - 1
    points = lattice_points(lattice, rows[0], rows[-1] + 2, 1)[:, 0]
    waves = points[rows - rows[0]] + parts * (points[rows - rows[0] + 1] - points[rows - rows[0]])
    from_x = -(np.float32(x) + np.float32(2 * jitter) * (waves - np.float32(0.5)))
    down = math.floor(from_y), np.float32(from_y - math.floor(from_y))
    moved = np.array([plate in ("all", "chroma", each) for each in PLATES[1:4]], np.uint8)
    _move(picture, down, from_x, moved, weights * np.float32(plate == "chroma"), place.margin, out)
    return out


@compiled
def _move(picture, down, from_x, moved, weights, margin, out):  # type: ignore[no-untyped-def]
    """The picture between pixels for channels that are moved; the luma of its own where it has weights."""
    height, width, zero, one = out.shape[0], out.shape[1], np.float32(0), np.float32(1)
    for row in range(margin[0], height - margin[1]):
        upper, lower = min(max(row + down[0], 0), height - 1), min(max(row + down[0] + 1, 0), height - 1)
        first = np.floor(from_x[row])
        whole = int(first)
        part = from_x[row] - first
        for column in range(width):
            left = min(max(column + whole, 0), width - 1)
            right = min(max(column + whole + 1, 0), width - 1)
            added = zero
            for channel in range(3):
                value = picture[row, column, channel]
                added += weights[channel] * value
                if moved[channel]:
                    above = picture[upper, left, channel]
                    above += part * (picture[upper, right, channel] - above)
                    below = picture[lower, left, channel]
                    below += part * (picture[lower, right, channel] - below)
                    value = above + down[1] * (below - above)
                added -= weights[channel] * value
                out[row, column, channel] = value
            for channel in range(3):
                out[row, column, channel] = min(max(out[row, column, channel] + added, zero), one)
