"""Strokes: a painting in brush strokes of one colour each."""

from __future__ import annotations

import math
from typing import Annotated, Any

import numpy as np

from vidstyle.block import REDRAW_RATE, FrameTime, PageRegion, SavedRef, Slider, block, drawing_at
from vidstyle.core.kernels import compiled
from vidstyle.core.stroke_directions import stroke_directions
from vidstyle.core.white_noise import APART, noise_between, white_noise

NUMBERS = 4
"""Random numbers of a stroke: its place across and down, which one it lies above, its tone."""
BRISTLE = (16.0, 1.6)
"""Length and width of the marks of bristles, in pixels."""


LEAST_SHARE = 1 / 512
"""What of a pixel strokes have to leave open for those below to be drawn."""
MOST_ACROSS = 5
"""Squares of the grid along a stroke, at most: a pixel has to look for strokes in all of them."""


def _radius(length: float, width: float) -> int:
    return math.ceil(max(length, width) / 2 + 1)


@block("filter", on="color", radius=_radius)
def strokes(
    picture: np.ndarray,
    place: PageRegion,
    moment: FrameTime,
    flow: Annotated[Any, SavedRef("smoothed result of `structure_tensor`")] = "source",
    under: Annotated[Any, SavedRef("picture that shows between strokes")] = "source",
    length: Annotated[float, Slider(2, 96, "length of a stroke", "px", explore=(8, 36))] = 24,
    width: Annotated[float, Slider(2, 64, "width of a stroke", "px", explore=(4, 12))] = 7,
    density: Annotated[float, Slider(0.25, 4, "strokes in each square of a stroke's width")] = 1,
    angle: Annotated[float, Slider(-90, 90, "direction where there are no edges", "degrees")] = 35,
    variation: Annotated[float, Slider(0, 1, "how much strokes differ in tone", explore=(0, 0.2))] = 0.1,
    colors: Annotated[float, Slider(0, 1, "how much strokes differ in colour", explore=(0, 0.2))] = 0,
    bristles: Annotated[float, Slider(0, 1, "contrast of the marks of bristles", explore=(0, 0.5))] = 0.25,
    rate: Annotated[int, REDRAW_RATE] = 0,
) -> np.ndarray:
    """Paint with strokes of one colour each, along the edges; with dots where they are as wide as long.

    A stroke lies at a random place in its square of a grid, has the colour of the picture in its middle, and
    bends with the flow; which of two lies above the other is random. All is fixed to the page until it is
    drawn anew. Haeberli 1990, "Paint by Numbers: Abstract Image Representations".
    """
    reach, (height, columns) = _radius(length, width), picture.shape[:2]
    pitch = np.float32(max(width / math.sqrt(density), max(length, width) / MOST_ACROSS))
    # The squares of the grid in which a stroke may lie that is seen here.
    around = math.ceil(reach / pitch) + 1
    above, left = math.floor(place.top / pitch) - around, -around
    below, right = math.ceil((place.top + height) / pitch) + around, math.ceil(columns / pitch) + around
    drawing = drawing_at(moment, rate) * APART
    numbers = white_noise(np.arange(above, below) + drawing, np.arange(left * NUMBERS, right * NUMBERS))
    strokes_ = np.ascontiguousarray(numbers.reshape(below - above, right - left, NUMBERS))
    strokes_[..., 0] = (np.arange(left, right, dtype=np.float32) + strokes_[..., 0]) * pitch
    strokes_[..., 1] = (np.arange(above, below, dtype=np.float32)[:, None] + strokes_[..., 1]) * pitch
    strokes_[..., 1] -= np.float32(place.top)
    size = np.float32(max(length - width, 0) / 2), np.float32(width / 2), np.float32(reach), pitch
    chosen, out = np.empty(((2 * around + 1) ** 2, NUMBERS), np.float32), np.empty(picture.shape, np.float32)
    first = np.float32(above * pitch - place.top), np.float32(left * pitch)
    looks = np.float32(variation), np.float32(colors), np.float32(bristles)
    _paint(
        strokes_, around, first, size, looks, stroke_directions(flow, angle), (picture, under), chosen, out
    )
    return out


@compiled(fastmath=True)
def _choose(strokes_, row, column, around, edges, reach, chosen):  # type: ignore[no-untyped-def]
    """Copy the strokes that may be seen in a square, the uppermost first, and return their number."""
    count, (top, bottom, left, right) = 0, edges
    for i in range(row - around, row + around + 1):
        for j in range(column - around, column + around + 1):
            x, y, order = strokes_[i, j, 0], strokes_[i, j, 1], strokes_[i, j, 2]
            dx, dy = max(left - x, x - right, np.float32(0)), max(top - y, y - bottom, np.float32(0))
            if dx * dx + dy * dy > reach * reach:
                continue
            at = count
            while at > 0 and chosen[at - 1, 2] < order:
                for k in range(4):
                    chosen[at, k] = chosen[at - 1, k]
                at -= 1
            for k in range(4):
                chosen[at, k] = strokes_[i, j, k]
            count += 1
    return count


@compiled(fastmath=True)
def _paint(strokes_, around, first, size, looks, directions, pictures, chosen, out):  # type: ignore[no-untyped-def]
    """Square by square, whose pixels see the same strokes, from the uppermost down."""
    (half_length, half_width, reach, pitch), (picture, under) = size, pictures
    (variation, colors, bristles), least_share = looks, np.float32(LEAST_SHARE)
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    along_scale, across_scale = np.float32(1 / BRISTLE[0]), np.float32(1 / BRISTLE[1])
    (cosines, sines), least = directions, (half_width + half) * (half_width + half)
    height, columns = out.shape[0], out.shape[1]
    for i in range(around, strokes_.shape[0] - around):
        top = first[0] + np.float32(i) * pitch
        rows = max(int(np.ceil(top - half)), 0), min(int(np.ceil(top + pitch - half)), height)
        for j in range(around, strokes_.shape[1] - around):
            left = first[1] + np.float32(j) * pitch
            start, end = max(int(np.ceil(left - half)), 0), min(int(np.ceil(left + pitch - half)), columns)
            if rows[0] >= rows[1] or start >= end:
                continue
            count = _choose(strokes_, i, j, around, (top, top + pitch, left, left + pitch), reach, chosen)
            for y in range(rows[0], rows[1]):
                for x in range(start, end):
                    cosine, sine = cosines[y, x], sines[y, x]
                    red, green, blue, shown = zero, zero, zero, one
                    for k in range(count):
                        dx, dy = np.float32(x) + half - chosen[k, 0], np.float32(y) + half - chosen[k, 1]
                        along, across = dx * cosine + dy * sine, dy * cosine - dx * sine
                        beyond = max(abs(along) - half_length, zero)
                        squared = beyond * beyond + across * across
                        if squared >= least:
                            continue
                        cover = min(half_width + half - np.sqrt(squared), one)
                        tone = chosen[k, 3]
                        change = variation * (tone - half)
                        # The same for the opposite direction, which is the same direction.
                        own = tone * np.float32(512) + np.float32(64)
                        mark = noise_between(own + abs(along) * along_scale, own + abs(across) * across_scale)
                        change += bristles * (mark - half)
                        row = min(max(int(np.floor(chosen[k, 1])), 0), height - 1)
                        column = min(max(int(np.floor(chosen[k, 0])), 0), columns - 1)
                        share = shown * cover
                        more, less = tone * np.float32(7), tone * np.float32(13)
                        other = (
                            colors * (more - np.floor(more) - half),
                            colors * (less - np.floor(less) - half),
                        )
                        red += share * min(max(picture[row, column, 0] + change + other[0], zero), one)
                        green += share * min(
                            max(picture[row, column, 1] + change - half * (other[0] + other[1]), zero), one
                        )
                        blue += share * min(max(picture[row, column, 2] + change + other[1], zero), one)
                        shown -= share
                        if shown < least_share:
                            break
                    out[y, x, 0] = red + shown * under[y, x, 0]
                    out[y, x, 1] = green + shown * under[y, x, 1]
                    out[y, x, 2] = blue + shown * under[y, x, 2]
