"""Line integral convolution: noise smeared along edges."""

from __future__ import annotations

import math
from typing import Annotated

import cv2
import numpy as np

from vidstyle.block import REDRAW_RATE, FrameTime, PageRegion, Slider, block, drawing_at
from vidstyle.core.kernels import compiled
from vidstyle.core.stroke_directions import stroke_directions
from vidstyle.core.white_noise import APART, white_noise


def _steps(length: float, size: float) -> int:
    return math.ceil(length / 2 / size)


def _radius(length: float, size: float) -> int:
    return math.ceil(_steps(length, size) * size) + 2


@block("filter", on="color", radius=_radius)
def lic(
    picture: np.ndarray,
    place: PageRegion,
    moment: FrameTime,
    length: Annotated[float, Slider(2, 64, "length of the strokes", "px", explore=(8, 40))] = 20,
    size: Annotated[float, Slider(1, 16, "width of the strokes", "px", explore=(1, 4))] = 1.5,
    angle: Annotated[float, Slider(-90, 90, "direction where there are no edges", "degrees")] = 30,
    contrast: Annotated[float, Slider(0, 2, "0 for even gray")] = 1,
    rate: Annotated[int, REDRAW_RATE] = 0,
) -> np.ndarray:
    """Draw strokes along the edges, black on white: bristles, hatching, fur.

    Takes the smoothed result of `structure_tensor` and smears noise along it, with weights that fall off
    towards both ends; the noise is fixed to the page until it is drawn anew. Cabral and Leedom 1993, "Imaging
    Vector Fields Using Line Integral Convolution"; steps as long as the strokes are wide, by Euler's method.
    """
    size = float(np.float32(size))
    reach, (height, width) = _radius(length, size), picture.shape[:2]
    # Beyond the picture, so that no step has to look for its border.
    around = [
        cv2.copyMakeBorder(each, *(reach,) * 4, cv2.BORDER_REPLICATE)
        for each in stroke_directions(picture, angle)
    ]
    lead = math.ceil(reach / size) + 1  # points of the noise around a pixel
    rows, columns = _places(place.top, height, size, lead), _places(0, width, size, lead)
    points = [np.arange(each[0][0], each[0][-1] + 2 * lead + 2) for each in (rows, columns)]
    noise = white_noise(points[0] + drawing_at(moment, rate) * APART, points[1])
    # Means of noise are paler the longer and finer the strokes.
    gain = np.float32(contrast * math.sqrt(1 + length / (2 * size)))
    out = np.empty((height, width), np.float32)
    way = _steps(length, size), np.float32(size), reach
    flat = tuple(each.reshape(-1) for each in (*around, noise))
    _smear(flat, (around[0].shape[1], noise.shape[1]), rows, columns, way, gain, place.margin, out)
    return np.dstack([out] * 3)


def _places(first: int, count: int, size: float, lead: int) -> tuple[np.ndarray, np.ndarray]:
    """Where pixels lie upon the noise: a point `lead` points before each, and how far behind it the pixel is.

    The same for a pixel of the page wherever its band begins.
    """
    places = (np.arange(first, first + count) + 0.5) / size
    points = np.floor(places).astype(np.int64)
    return points - lead, (places - points + lead).astype(np.float32)


@compiled(fastmath=True)
def _noise_at(noise, columns, first, y, x):  # type: ignore[no-untyped-def]
    """Noise between the points of its lattice."""
    row, column = np.uint32(y), np.uint32(x)
    below, beside = y - np.float32(row), x - np.float32(column)
    at, next_one = first + row * np.uint32(columns) + column, np.uint32(1)
    under = at + np.uint32(columns)
    upper = noise[at] + beside * (noise[at + next_one] - noise[at])
    lower = noise[under] + beside * (noise[under + next_one] - noise[under])
    return upper + below * (lower - upper)


@compiled(fastmath=True)
def _smear(flat, widths, rows, columns, way, gain, margin, out):  # type: ignore[no-untyped-def]
    """The weighted mean of the noise along the directions, to both sides."""
    (rights, downs, noise), (steps, size, reach) = flat, way
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    per_pixel, fall, total = one / size, one / np.float32(steps + 1), np.float32(steps + 1)
    width, middle = np.uint32(widths[0]), np.float32(reach) + half
    for row in range(margin[0], out.shape[0] - margin[1]):
        for column in range(out.shape[1]):
            first = np.uint32((rows[0][row] - rows[0][0]) * widths[1] + columns[0][column] - columns[0][0])
            y, x, corner = rows[1][row], columns[1][column], np.uint32(row) * width + np.uint32(column)
            at = corner + np.uint32(reach) * width + np.uint32(reach)
            mean = _noise_at(noise, widths[1], first, y, x)
            for side in range(2):
                turn = one if side == 0 else -one
                right, down, across, along, weight = turn * rights[at], turn * downs[at], zero, zero, one
                for _ in range(steps):
                    across, along, weight = across + size * right, along + size * down, weight - fall
                    value = _noise_at(noise, widths[1], first, y + along * per_pixel, x + across * per_pixel)
                    mean += weight * value
                    there = corner + np.uint32(middle + along) * width + np.uint32(middle + across)
                    turn = one if rights[there] * right + downs[there] * down >= zero else -one
                    right, down = turn * rights[there], turn * downs[there]
            out[row, column] = min(max(half + gain * (mean / total - half), zero), one)
