"""Palette: the nearest of a few colours."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Asset, ResultRows, block, rgb_from_text
from vidstyle.core.color.film_colors import FilmTable
from vidstyle.core.color.oklab import CONE_WEIGHTS, LAB_WEIGHTS, lab_from_rgb
from vidstyle.core.file_checks import read_regular_file
from vidstyle.core.kernels import TIE_LIFT, cached, compiled, index_at, interleaved, look_up_at

MAX_COLORS = 64
MAX_FILE_BYTES = 4096

SIDE_CELLS = 64
"""Cubes along each side of the table of precomputed answers."""
UNSURE_CODE = 255
"""Marks a cube of this table within which more than one colour is the nearest."""

FILM_KEYWORD = "film"
"""In a palette file, before a number N: the N main colours of the film."""


def shipped_palettes() -> dict[str, Path]:
    """Return the shipped palettes by name."""
    return {file.stem: file for file in Path(__file__).with_name("palettes").glob("*.txt")}


def read_palette(path: Path) -> tuple[np.ndarray]:
    """Read a text file of colours, one `#rrggbb` per line; or "film N" for the N main colours of the film.

    Returns:
        One table, 6 x colours float32: OKLab, then red, green and blue 0..1. A `FilmTable` for colours of the
        film.

    Raises:
        ValueError: a line is not a colour, or the number of colours is not 2 to 64.
        OSError: the file cannot be read.
    """
    lines = read_regular_file(path, MAX_FILE_BYTES).decode("ascii", "replace").split()
    if lines[:1] == [FILM_KEYWORD] and len(lines) == 2 and lines[1].isdecimal():
        lines = ["#000000"] * min(int(lines[1]), MAX_COLORS + 1)
        return FilmTable(_table(lines))
    if wrong := next((line for line in lines if not re.fullmatch("#[0-9a-fA-F]{6}", line)), None):
        raise ValueError(f"{wrong[:16]!r} is not #rrggbb")
    return _table(lines)


def _table(lines: list[str]) -> tuple[np.ndarray]:
    if not 2 <= len(lines) <= MAX_COLORS:
        raise ValueError(f"needs 2 to {MAX_COLORS} colours, has {len(lines)}")
    colors = np.array([rgb_from_text(line) for line in lines]).T
    return (np.vstack([lab_from_rgb(colors), colors]).astype(np.float32),)


@block(
    "pixel",
    on="color",
    label="Colour palette",
    category="color",
    aliases=(
        "few colours, limited colours, reduce colours, quantize, duotone, 8-bit, pixel art, retro, "
        "recolor, posterize, two tone, game console"
    ),
)
def palette(
    picture: np.ndarray,
    out: ResultRows,
    colors: Annotated[
        Any,
        Asset(
            "name of a palette, or a text file of #rrggbb lines",
            read_palette,
            shipped_palettes,
            label="Palette",
        ),
    ] = "ember",
) -> np.ndarray:
    """Reduce the picture to a few colours, given or taken from the film.

    Each colour becomes the nearest of a palette of 2 to 64 colours, compared in OKLab. Put `dither`
    before it to mix colours. The palettes "film-8", "film-16" and "film-32" are the main colours of the
    unstyled film. Ottosson 2020, "A perceptual color space for image processing".
    """
    (table,) = colors
    sure = _sure_answers(table.tobytes())
    to_lab = CONE_WEIGHTS.astype(np.float32), LAB_WEIGHTS.astype(np.float32)
    numbers, values = np.empty((4, picture.shape[1]), np.int32), np.empty((4, picture.shape[1]), np.float32)
    _choose(interleaved(picture), sure, table, to_lab, TIE_LIFT, numbers, values, interleaved(out))
    return out


@cached(maxsize=4)
def _sure_answers(table: bytes) -> np.ndarray:
    """Return the colour nearest to all corners of each cube, or `UNSURE_CODE`: SIDE_CELLS ** 3 uint8."""
    points = np.frombuffer(table, np.float32).reshape(6, -1)[:3]
    planes, sure = np.empty((2, (SIDE_CELLS + 1) ** 2), np.uint8), np.empty(SIDE_CELLS**3, np.uint8)
    _compare_corners(_corners(), np.ascontiguousarray(points), planes, sure)
    return sure


@cached(maxsize=1)
def _corners() -> np.ndarray:
    """Return the OKLab values of the corners of all cubes, (SIDE_CELLS + 1) ** 3 x 3 float32."""
    levels = np.arange(SIDE_CELLS + 1) / SIDE_CELLS
    planes = [np.stack(np.meshgrid([red], levels, levels, indexing="ij")).reshape(3, -1) for red in levels]
    return np.concatenate([lab_from_rgb(plane).T.astype(np.float32) for plane in planes])


@compiled
def _compare_corners(corners, points, planes, sure):  # type: ignore[no-untyped-def]
    """Find the point nearest to each corner, plane by plane, then the answers of the cubes between planes."""
    side, plane = SIDE_CELLS, (SIDE_CELLS + 1) ** 2
    for red in range(side + 1):
        for i in range(plane):
            lab, nearest, least = corners[red * plane + i], 0, np.float32(1e9)
            for number in range(points.shape[1]):
                x, y, z = lab[0] - points[0, number], lab[1] - points[1, number], lab[2] - points[2, number]
                distance = x * x + y * y + z * z
                if distance < least:
                    nearest, least = number, distance
            planes[red % 2, i] = nearest
        for green in range(side if red else 0):
            for blue in range(side):
                corner, answer = green * (side + 1) + blue, planes[0, green * (side + 1) + blue]
                for k in range(2):
                    for step in (0, 1, side + 1, side + 2):
                        if planes[k, corner + step] != answer:
                            answer = UNSURE_CODE
                sure[((red - 1) * side + green) * side + blue] = answer


@compiled(fastmath=True)
def _cube_root(x):  # type: ignore[no-untyped-def]
    """Return the cube root of x >= 0, by a third of its exponent and Halley's method."""
    y = np.int32(np.float32(x).view(np.int32) // np.int32(3) + np.int32(709958130)).view(np.float32)
    for _ in range(2):
        cube = y * y * y
        y *= (cube + x + x) / (cube + cube + x)
    return y


@compiled(fastmath=True)
def _linear(value):  # type: ignore[no-untyped-def]
    """Return the linear light of an sRGB value; the power 2.4 uses a fifth root by Newton's method."""
    x = max((value + np.float32(0.055)) * np.float32(1 / 1.055), np.float32(0.05))
    y = np.int32(np.float32(x).view(np.int32) // np.int32(5) + np.int32(852282573)).view(np.float32)
    for _ in range(3):
        y = np.float32(0.8) * y + np.float32(0.2) * x / (y * y * y * y)
    return value * np.float32(1 / 12.92) if value <= np.float32(0.04045) else x * x * y * y


@compiled(fastmath=True, noalias=True)
def _to_lab(count, to_lab, values):  # type: ignore[no-untyped-def]
    """Convert the first `count` colours to OKLab, in place."""
    cones, lab = to_lab
    first, second, third = values[0], values[1], values[2]
    for i in range(count):
        red, green, blue = _linear(first[i]), _linear(second[i]), _linear(third[i])
        long = _cube_root(cones[0, 0] * red + cones[0, 1] * green + cones[0, 2] * blue)
        medium = _cube_root(cones[1, 0] * red + cones[1, 1] * green + cones[1, 2] * blue)
        short = _cube_root(cones[2, 0] * red + cones[2, 1] * green + cones[2, 2] * blue)
        first[i] = lab[0, 0] * long + lab[0, 1] * medium + lab[0, 2] * short
        second[i] = lab[1, 0] * long + lab[1, 1] * medium + lab[1, 2] * short
        third[i] = lab[2, 0] * long + lab[2, 1] * medium + lab[2, 2] * short


@compiled
def _find_nearest(count, table, nearest, values):  # type: ignore[no-untyped-def]
    """Find the nearest colour for each of the first `count` values; the first one for ties and NaN."""
    lightness, a, b, least = values[0], values[1], values[2], values[3]
    for i in range(count):
        nearest[i], least[i] = np.int32(0), np.float32(1e9)
    for number in range(table.shape[1]):
        u, v, w = table[0, number], table[1, number], table[2, number]
        for i in range(count):
            x, y, z = lightness[i] - u, a[i] - v, b[i] - w
            distance = x * x + y * y + z * z
            is_nearer = distance < least[i]
            nearest[i] = np.int32(number) if is_nearer else nearest[i]
            least[i] = distance if is_nearer else least[i]


@compiled
def _choose(colors, sure, table, to_lab, lift, numbers, values, out):  # type: ignore[no-untyped-def]
    """Choose the nearest colour of the palette; copy rows equal to the previous one, as from `pixelate`.

    Args:
        numbers, values: scratch for a row.
    """
    chosen, unsure, places, nearest = numbers[0], numbers[1], numbers[2], numbers[3]
    for row in range(out.shape[0]):
        differs = row == 0
        for x in range(out.shape[1] if row else 0):
            differs |= colors[row, x] != colors[row - 1, x]
        if not differs:
            for x in range(out.shape[1]):
                out[row, x] = out[row - 1, x]
            continue
        _number_cubes(colors[row], lift, chosen)
        count = _look_up(sure, chosen, unsure)
        distinct = _collect(count, colors[row], unsure, lift, places, values)
        _to_lab(distinct, to_lab, values)
        _find_nearest(distinct, table, nearest, values)
        for i in range(count):
            chosen[unsure[i]] = nearest[places[i]]
        _paint(chosen, table, out[row])


@compiled(noalias=True)
def _number_cubes(colors, lift, numbers):  # type: ignore[no-untyped-def]
    one, side = np.float32(1), np.float32(SIDE_CELLS)
    for x in range(numbers.size):
        red = index_at(min(colors[3 * x] + lift, one) * side, SIDE_CELLS - 1)
        green = index_at(min(colors[3 * x + 1] + lift, one) * side, SIDE_CELLS - 1)
        blue = index_at(min(colors[3 * x + 2] + lift, one) * side, SIDE_CELLS - 1)
        numbers[x] = (red * np.int32(SIDE_CELLS) + green) * np.int32(SIDE_CELLS) + blue


@compiled(noalias=True)
def _look_up(sure, chosen, unsure):  # type: ignore[no-untyped-def]
    """Replace numbers of cubes by numbers of colours; list unsure positions and return their count."""
    count = 0
    for x in range(chosen.size):
        chosen[x] = sure[chosen[x]]
        unsure[count] = x
        count += chosen[x] == UNSURE_CODE
    return count


@compiled(noalias=True)
def _collect(count, colors, unsure, lift, places, values):  # type: ignore[no-untyped-def]
    """Collect distinct consecutive unsure colours, write their index to `places`, return their count."""
    zero, one, distinct = np.float32(0), np.float32(1), 0
    for i in range(count):
        x, last = 3 * unsure[i], max(distinct - 1, 0)
        red = min(max(colors[x] + lift, zero), one)
        green = min(max(colors[x + 1] + lift, zero), one)
        blue = min(max(colors[x + 2] + lift, zero), one)
        differs = red != values[0, last] or green != values[1, last] or blue != values[2, last]
        distinct += i == 0 or differs
        places[i] = distinct - 1
        values[0, places[i]], values[1, places[i]], values[2, places[i]] = red, green, blue
    return distinct


@compiled(noalias=True)
def _paint(numbers, table, out):  # type: ignore[no-untyped-def]
    red, green, blue = table[3], table[4], table[5]
    for x in range(numbers.size):
        number = look_up_at(numbers[x])
        out[3 * x], out[3 * x + 1], out[3 * x + 2] = red[number], green[number], blue[number]
