"""Line integral convolution: noise smeared along edges."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from vidstyle.block import PageRegion, Slider, block
from vidstyle.core.kernels import compiled, index_at

STILL = 0.06
"""Strength of the fixed direction beside that of edges: it decides where there are none."""


def _steps(length: float, size: float) -> int:
    return math.ceil(length / 2 / size)


def _radius(length: float, size: float) -> int:
    return math.ceil(_steps(length, size) * size) + 2


@block("filter", on="color", radius=_radius)
def lic(
    picture: np.ndarray,
    place: PageRegion,
    length: Annotated[float, Slider(2, 64, "length of the strokes", "px", explore=(8, 40))] = 20,
    size: Annotated[float, Slider(1, 16, "width of the strokes", "px", explore=(1, 4))] = 1.5,
    angle: Annotated[float, Slider(-90, 90, "direction where there are no edges", "degrees")] = 30,
    contrast: Annotated[float, Slider(0, 2, "0 for even gray")] = 1,
) -> np.ndarray:
    """Draw strokes along the edges, black on white: bristles, hatching, fur.

    Takes the smoothed result of `structure_tensor` and smears noise, which is fixed to the page, along it,
    with weights that fall off towards both ends. Cabral and Leedom 1993, "Imaging Vector Fields Using Line
    Integral Convolution"; steps as long as the strokes are wide, by Euler's method.
    """
    size = float(np.float32(size))
    directions = _directions(picture, angle)
    reach, (height, width) = _radius(length, size), picture.shape[:2]
    first = math.floor((place.top - reach) / size) - 1, math.floor(-reach / size) - 1
    last = math.ceil((place.top + height + reach) / size) + 2, math.ceil((width + reach) / size) + 2
    noise = white_noise(*(np.arange(low, high) for low, high in zip(first, last, strict=True)))
    # Means of noise are paler the longer and finer the strokes.
    gain = np.float32(contrast * math.sqrt(1 + length / (2 * size)))
    out = np.empty((height, width), np.float32)
    way = _steps(length, size), np.float32(size)
    _smear(*directions, noise, first, place.top, way, gain, place.margin, out)
    return np.dstack([out] * 3)


def _directions(flow: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """The unit vector along the edge at each pixel: to the right and down, H x W float32 each."""
    turn = math.radians(-2 * angle)  # in the picture, y points down
    # Minus: along the edge, a right angle from the gradient.
    x = np.float32(STILL * math.cos(turn)) - (2 * flow[..., 0] - 1)
    y = np.float32(STILL * math.sin(turn)) - (2 * flow[..., 1] - 1)
    cosine, sine = np.stack([x, y]) / np.maximum(np.sqrt(x * x + y * y), np.float32(1e-12))
    # Half the angle: the longer part by its root, the other, which would lose digits so, by their product.
    longer = np.sqrt(np.float32(0.5) + np.float32(0.5) * np.abs(cosine))
    shorter = np.abs(sine) / (2 * longer)
    upright = cosine < 0
    return np.where(upright, shorter, longer), np.copysign(np.where(upright, longer, shorter), y)


def white_noise(rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Uniform random numbers 0..1 for the points of a lattice that runs on for ever.

    Args:
        rows, columns: of the points, whole numbers.

    Returns:
        rows x columns float32, the same for the same point.
    """
    bits = (columns.astype(np.uint32) * np.uint32(0x9E3779B1))[None] ^ (
        rows.astype(np.uint32) * np.uint32(0x85EBCA77)
    )[:, None]
    for shift, factor in ((15, 0x2C1B3C6D), (12, 0x297A2D39)):
        bits = (bits ^ (bits >> np.uint32(shift))) * np.uint32(factor)
    return ((bits ^ (bits >> np.uint32(15))) >> np.uint32(8)).astype(np.float32) * np.float32(2.0**-24)


@compiled(fastmath=True)
def _noise_at(noise, first, down, right, per_pixel):  # type: ignore[no-untyped-def]
    """Noise between the points of its lattice; 0.5 is the middle of the first pixel."""
    y, x = down * per_pixel - np.float32(first[0]), right * per_pixel - np.float32(first[1])
    row, column = index_at(y, noise.shape[0] - 2), index_at(x, noise.shape[1] - 2)
    below, beside = y - np.float32(row), x - np.float32(column)
    upper = noise[row, column] + beside * (noise[row, column + 1] - noise[row, column])
    lower = noise[row + 1, column] + beside * (noise[row + 1, column + 1] - noise[row + 1, column])
    return upper + below * (lower - upper)


@compiled(fastmath=True)
def _smear(rights, downs, noise, first, top, way, gain, margin, out):  # type: ignore[no-untyped-def]
    (height, width), (steps, size) = out.shape, way
    per_pixel = np.float32(1) / size
    zero, half, one = np.float32(0), np.float32(0.5), np.float32(1)
    fall = one / np.float32(steps + 1)
    total = np.float32(steps + 1)  # of the weights: 1 and twice those of the steps
    for row in range(margin[0], height - margin[1]):
        for column in range(width):
            y, x = np.float32(row) + half, np.float32(column) + half
            mean = _noise_at(noise, first, y + np.float32(top), x, per_pixel)
            for side in range(2):
                right, down = rights[row, column], downs[row, column]
                right, down = (right, down) if side == 0 else (-right, -down)
                to_x, to_y, weight = x, y, one
                for _ in range(steps):
                    to_x, to_y, weight = to_x + size * right, to_y + size * down, weight - fall
                    mean += weight * _noise_at(noise, first, to_y + np.float32(top), to_x, per_pixel)
                    at_row, at_column = index_at(to_y, height - 1), index_at(to_x, width - 1)
                    next_right, next_down = rights[at_row, at_column], downs[at_row, at_column]
                    if next_right * right + next_down * down < zero:
                        next_right, next_down = -next_right, -next_down
                    right, down = next_right, next_down
            out[row, column] = min(max(half + gain * (mean / total - half), zero), one)
