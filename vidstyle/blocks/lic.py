"""Line integral convolution: noise smeared along edges."""

from __future__ import annotations

import math
from typing import Annotated

import cv2
import numpy as np

from vidstyle.block import REDRAW_RATE, FrameTime, PageRegion, Slider, block, drawing_at
from vidstyle.core.kernels import compiled
from vidstyle.core.stroke_directions import STILL, stroke_directions
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
    angle_strength: Annotated[float, Slider(0.01, 1, "strength of that direction beside weak edges")] = STILL,
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
    directions = np.stack(stroke_directions(picture, angle, angle_strength), axis=-1)
    around = cv2.copyMakeBorder(directions, *(reach,) * 4, cv2.BORDER_REPLICATE)
    lead = math.ceil(reach / size) + 1  # points of the noise around a pixel
    rows, columns = _places(place.top, height, size, lead), _places(0, width, size, lead)
    points = [np.arange(each[0][0], each[0][-1] + 2 * lead + 2) for each in (rows, columns)]
    noise = _interpolation(white_noise(points[0] + drawing_at(moment, rate) * APART, points[1]))
    # Means of noise are paler the longer and finer the strokes.
    gain = np.float32(contrast * math.sqrt(1 + length / (2 * size)))
    out = np.empty((height, width), np.float32)
    way = _steps(length, size), np.float32(size), reach
    flat = around.reshape(-1), noise.reshape(-1)
    _smear(flat, (around.shape[1], noise.shape[1]), rows, columns, way, gain, place.margin, out)
    return cv2.merge([out] * 3)


def _places(first: int, count: int, size: float, lead: int) -> tuple[np.ndarray, np.ndarray]:
    """Where pixels lie upon the noise: a point `lead` points before each, and how far behind it the pixel is.

    The same for a pixel of the page wherever its band begins.
    """
    places = (np.arange(first, first + count) + 0.5) / size
    points = np.floor(places).astype(np.int64)
    return points - lead, (places - points + lead).astype(np.float32)


def _interpolation(noise: np.ndarray) -> np.ndarray:
    """What bilinear interpolation multiplies by 1, x, y and xy, behind each point of the lattice.

    Four numbers that lie side by side are read as one, and take fewer steps than four points of the lattice.
    """
    across, down = np.diff(noise[:-1], axis=1), np.diff(noise[:, :-1], axis=0)
    return np.stack([noise[:-1, :-1], across, down, np.diff(noise[1:], axis=1) - across], axis=-1)


@compiled(fastmath=True)
def _noise_at(noise, columns, first, y, x):  # type: ignore[no-untyped-def]
    """Noise between the points of its lattice."""
    row, column = np.uint32(y), np.uint32(x)
    below, beside = y - np.float32(row), x - np.float32(column)
    at = np.uint32(4) * (first + row * columns + column)
    upper = noise[at] + beside * noise[at + np.uint32(1)]
    return upper + below * (noise[at + np.uint32(2)] + beside * noise[at + np.uint32(3)])


@compiled(fastmath=True)
def _smear(flat, widths, rows, columns, way, gain, margin, out):  # type: ignore[no-untyped-def]
    """The weighted mean of the noise along the directions; the two sides do not wait for each other."""
    (directions, noise), (steps, size, reach) = flat, way
    zero, half, one, two = np.float32(0), np.float32(0.5), np.float32(1), np.uint32(2)
    per_pixel, fall, total = one / size, one / np.float32(steps + 1), np.float32(steps + 1)
    width, noise_width, middle = np.uint32(widths[0]), np.uint32(widths[1]), np.float32(reach) + half
    for row in range(margin[0], out.shape[0] - margin[1]):
        for column in range(out.shape[1]):
            first = np.uint32((rows[0][row] - rows[0][0]) * widths[1] + columns[0][column] - columns[0][0])
            y, x, corner = rows[1][row], columns[1][column], np.uint32(row) * width + np.uint32(column)
            at = two * (corner + np.uint32(reach) * width + np.uint32(reach))
            mean, weight = _noise_at(noise, noise_width, first, y, x), one
            right, down, across, along = directions[at], directions[at + np.uint32(1)], zero, zero
            left, up, back, behind = -right, -down, zero, zero
            for _ in range(steps):
                weight -= fall
                across, along, back, behind = (
                    across + size * right,
                    along + size * down,
                    back + size * left,
                    behind + size * up,
                )
                there = two * (corner + np.uint32(middle + along) * width + np.uint32(middle + across))
                other = two * (corner + np.uint32(middle + behind) * width + np.uint32(middle + back))
                ahead = _noise_at(noise, noise_width, first, y + along * per_pixel, x + across * per_pixel)
                mean += weight * ahead
                ahead = _noise_at(noise, noise_width, first, y + behind * per_pixel, x + back * per_pixel)
                mean += weight * ahead
                next_right, next_down = directions[there], directions[there + np.uint32(1)]
                turn = one if next_right * right + next_down * down >= zero else -one
                right, down = turn * next_right, turn * next_down
                next_left, next_up = directions[other], directions[other + np.uint32(1)]
                turn = one if next_left * left + next_up * up >= zero else -one
                left, up = turn * next_left, turn * next_up
            out[row, column] = min(max(half + gain * (mean / total - half), zero), one)
