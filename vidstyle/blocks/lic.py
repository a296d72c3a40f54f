"""Line integral convolution: noise smeared along edges."""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from vidstyle.block import REDRAW_RATE, FrameTime, PageRegion, Slider, block, drawing_at
from vidstyle.core.kernels import cached, compiled, gray_rgb, look_up_at
from vidstyle.core.marks.stroke_directions import DEFAULT_ANGLE_STRENGTH, stroke_directions
from vidstyle.core.white_noise import LATTICE_PART_SIZE, MAX_PAIR_CODE, between_pair, pairs_of, white_noise


def _steps(length: float, size: float) -> int:
    return math.ceil(length / 2 / size)


def _radius(length: float, size: float) -> int:
    return math.ceil(_steps(length, size) * size) + 2


@block(
    "filter",
    on="color",
    radius=_radius,
    label="Bristles",
    category="paint",
    aliases=(
        "pencil, crayon, charcoal, chalk, pastel, hatching, fur, brush marks, wood grain, canvas, "
        "line integral convolution, texture, graphite"
    ),
)
def lic(
    picture: np.ndarray,
    place: PageRegion,
    moment: FrameTime,
    length: Annotated[
        float, Slider(2, 64, "length of the strokes", "px", explore=(8, 40), label="Stroke length")
    ] = 20,
    size: Annotated[
        float, Slider(1, 16, "width of the strokes", "px", explore=(1, 4), label="Stroke width")
    ] = 1.5,
    angle: Annotated[
        float, Slider(-90, 90, "direction of strokes far from edges", "degrees", label="Stroke direction")
    ] = 30,
    angle_strength: Annotated[
        float, Slider(0.01, 1, "strength of that direction near weak edges", label="Direction strength")
    ] = DEFAULT_ANGLE_STRENGTH,
    contrast: Annotated[
        float, Slider(0, 2, "contrast of the strokes; 0 for uniform gray", label="Stroke contrast")
    ] = 1,
    rate: Annotated[int, REDRAW_RATE] = 0,
) -> np.ndarray:
    """Draw black strokes on white along the edges, like bristles, hatching or fur.

    Takes the smoothed result of `structure_tensor` and smears noise along it, with weights that decrease
    towards both ends. The noise is fixed to the page and changes only at `rate`. Cabral and Leedom 1993,
    "Imaging Vector Fields Using Line Integral Convolution"; integrated by Euler's method, with the stroke
    width as step.
    """
    size = float(np.float32(size))
    reach, (height, width) = _radius(length, size), picture.shape[:2]
    # Extended beyond the picture, so that steps need not check for the border.
    around = np.empty((height + 2 * reach, 2 * (width + 2 * reach)), np.float32)
    _surround(*stroke_directions(picture, angle, angle_strength), reach, around)
    lead = math.ceil(reach / size) + 1  # points of noise around a pixel
    rows, columns = _places(place.top, height, size, lead), _places(0, width, size, lead)
    points = [(int(each[0][0]), int(each[0][-1]) + 2 * lead + 2) for each in (rows, columns)]
    noise = _noise_pairs(points[0], points[1], drawing_at(moment, rate) * LATTICE_PART_SIZE)
    # The longer and finer the strokes, the lower the contrast of the averaged noise.
    gain = np.float32(contrast * math.sqrt(1 + length / (2 * size)))
    out = np.empty((height, width), np.float32)
    way = _steps(length, size), np.float32(size), reach
    flat, lines = (around.reshape(-1), noise.reshape(-1)), np.empty((5, width), np.float32)
    widths = width + 2 * reach, noise.shape[1]
    _smear(flat, widths, rows, columns, way, gain, place.margin, lines, out)
    return gray_rgb(out)


@cached(maxsize=64)
def _noise_pairs(rows: tuple[int, int], columns: tuple[int, int], drawing: int) -> np.ndarray:
    """Return the noise between two rows and two columns; cached for the last few bands."""
    return pairs_of(white_noise(np.arange(*rows) + drawing, np.arange(*columns)))


def _places(first: int, count: int, size: float, lead: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the position of pixels on the noise: the point `lead` points before each, and the rest.

    The position of a pixel of the page does not depend on where its band begins.
    """
    places = (np.arange(first, first + count) + 0.5) / size
    points = np.floor(places).astype(np.int32)
    return points - np.int32(lead), (places - points + lead).astype(np.float32)


@compiled
def _surround(right, down, reach, around):  # type: ignore[no-untyped-def]
    """Interleave both components of the directions, and repeat the border by `reach` pixels."""
    height, width = right.shape
    for row in range(around.shape[0]):
        inside = min(max(row - reach, 0), height - 1)
        x, y, before, behind = right[inside], down[inside], around[row], around[row][2 * (reach + width) :]
        own = before[2 * reach :]
        for i in range(reach):
            before[2 * i], before[2 * i + 1] = x[0], y[0]
            behind[2 * i], behind[2 * i + 1] = x[width - 1], y[width - 1]
        for i in range(width):
            own[2 * i], own[2 * i + 1] = x[i], y[i]


@compiled(fastmath=True)
def _noise_at(noise, columns, first, y, x):  # type: ignore[no-untyped-def]
    """Interpolate the noise, 0..`PAIR_CODES`, between lattice points; `first`: index of its first point."""
    row, column = np.int32(y), np.int32(x)
    lower_weight, right_weight = y - np.float32(row), x - np.float32(column)
    at = look_up_at(np.int32(first + np.int32(np.int32(row * columns) + column)))
    upper = between_pair(noise[at], right_weight)
    lower = between_pair(noise[columns:][at], right_weight)
    return upper + lower_weight * (lower - upper)


@compiled(fastmath=True)
def _smear(flat, widths, rows, columns, way, gain, margin, lines, out):  # type: ignore[no-untyped-def]
    """Compute the weighted mean of the noise along the directions, row by row and step by step.

    All pixels of a row take a step together, vectorized.

    Args:
        lines: scratch, five rows: for each pixel the direction of the next step, the distance covered, and
            the sum of the noise on the way.
    """
    (directions, noise), (steps, size, reach) = flat, way
    half, one, total = np.float32(0.5), np.float32(1), np.float32(steps + 1)
    right, down, across, along, mean = lines[0], lines[1], lines[2], lines[3], lines[4]
    starts, x = columns
    for row in range(margin[0], out.shape[0] - margin[1]):
        first, y = (rows[0][row] - rows[0][0]) * widths[1] - starts[0], rows[1][row]
        own = directions[2 * ((row + reach) * widths[0] + reach) :]
        lattice, place = (widths[1], first, y), (widths[0], row, reach)
        for i in range(mean.size):
            mean[i] = 0
            across[i], along[i] = 0, 0
        _add_noise(noise, lattice, starts, x, (one / size, one), lines)
        for side in range(2):
            turn, weight = one if side == 0 else -one, one
            for i in range(mean.size):
                right[i], down[i] = turn * own[2 * i], turn * own[2 * i + 1]
                across[i], along[i] = size * right[i], size * down[i]
            for number in range(steps):
                if number > 0:
                    _turn(directions, place, size, lines)
                weight -= one / total
                _add_noise(noise, lattice, starts, x, (one / size, weight), lines)
        for i in range(mean.size):
            shown = mean[i] / (total * np.float32(MAX_PAIR_CODE))
            out[row, i] = min(max(half + gain * (shown - half), np.float32(0)), one)


@compiled(fastmath=True, noalias=True)
def _add_noise(noise, lattice, starts, x, scale, lines):  # type: ignore[no-untyped-def]
    """Add the noise at the current positions of the pixels."""
    (columns, first, y), (per_pixel, weight) = lattice, scale
    across, along, mean, width, begin = lines[2], lines[3], lines[4], np.int32(columns), np.int32(first)
    for i in range(mean.size):
        place = y + along[i] * per_pixel, x[i] + across[i] * per_pixel
        mean[i] += weight * _noise_at(noise, width, np.int32(begin + starts[i]), place[0], place[1])


@compiled(fastmath=True, noalias=True)
def _turn(directions, place, size, lines):  # type: ignore[no-untyped-def]
    """Move one step along the edge, never backwards."""
    right, down, across, along, (columns, row, reach) = lines[0], lines[1], lines[2], lines[3], place
    width, above, middle = np.int32(columns), np.int32(row), np.float32(reach) + np.float32(0.5)
    for i in range(right.size):
        # Relative to the pixel: far from the corner, absolute positions would lose precision.
        line = np.int32(above + np.int32(middle + along[i]))
        column = np.int32(np.int32(i) + np.int32(middle + across[i]))
        at = look_up_at(np.int32(2) * np.int32(np.int32(line * width) + column))
        next_right, next_down = directions[at], directions[1:][at]
        same = next_right * right[i] + next_down * down[i] >= np.float32(0)
        right[i], down[i] = next_right if same else -next_right, next_down if same else -next_down
        across[i] += size * right[i]
        along[i] += size * down[i]
