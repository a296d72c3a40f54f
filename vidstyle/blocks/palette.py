"""Palette: the nearest of a few colours."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Asset, block, rgb_from_text
from vidstyle.core.film_colors import FilmTable
from vidstyle.core.kernels import TIE_LIFT, cached, compiled, index_at
from vidstyle.core.oklab import TO_CONES, TO_LAB, lab_from_rgb
from vidstyle.core.regular_file import read_regular_file

MAX_COLORS = 64
MAX_FILE_BYTES = 4096

SIDE = 64
"""Cubes along each side of the table that knows most answers."""
UNSURE = 255
"""In this table: more than one colour is the nearest within the cube."""

FILM = "film"
"""In a file of colours, before a number: so many of the film's own."""


def shipped_palettes() -> dict[str, Path]:
    """The palettes that come with vidstyle, by name."""
    return {file.stem: file for file in Path(__file__).with_name("palettes").glob("*.txt")}


def read_palette(path: Path) -> tuple[np.ndarray]:
    """The colours of a text file, one `#rrggbb` a line; or "film 16" for so many of the film's own.

    Returns:
        One table, 6 x colours float32: their OKLab, and red, green and blue 0..1. A `FilmTable` for the
        film's own.

    Raises:
        ValueError: a line is not a colour, or there are not 2 to 64.
        OSError: it cannot be read.
    """
    lines = read_regular_file(path, MAX_FILE_BYTES).decode("ascii", "replace").split()
    if lines[:1] == [FILM] and len(lines) == 2 and lines[1].isdecimal():
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


@block("pixel", on="color")
def palette(
    picture: np.ndarray,
    colors: Annotated[
        Any, Asset("name of a palette, or a text file of #rrggbb lines", read_palette, shipped_palettes)
    ] = "ember",
) -> np.ndarray:
    """Replace each colour by the nearest of a palette of 2 to 64, in OKLab.

    `dither` before it mixes them. The palettes "film-8", "film-16" and "film-32" are the main colours of the
    film itself, as it is before the style. Ottosson 2020, "A perceptual color space for image processing".
    """
    (table,) = colors
    out = np.empty(picture.shape, np.float32)
    sure = _sure_answers(table.tobytes())
    cones, lab = TO_CONES.astype(np.float32), TO_LAB.astype(np.float32)
    _choose(picture.reshape(-1, 3), sure, table, cones, lab, TIE_LIFT, out.reshape(-1, 3))
    return out


@cached(maxsize=4)
def _sure_answers(table: bytes) -> np.ndarray:
    """For each cube of colours the nearest of the palette if all its corners share it: SIDE ** 3 uint8."""
    points = np.frombuffer(table, np.float32).reshape(6, -1)[:3]
    planes, sure = np.empty((2, (SIDE + 1) ** 2), np.uint8), np.empty(SIDE**3, np.uint8)
    _compare_corners(_corners(), np.ascontiguousarray(points), planes, sure)
    return sure


@cached(maxsize=1)
def _corners() -> np.ndarray:
    """OKLab of the corners of all cubes, (SIDE + 1) ** 3 x 3 float32."""
    levels = np.arange(SIDE + 1) / SIDE
    planes = [np.stack(np.meshgrid([red], levels, levels, indexing="ij")).reshape(3, -1) for red in levels]
    return np.concatenate([lab_from_rgb(plane).T.astype(np.float32) for plane in planes])


@compiled
def _compare_corners(corners, points, planes, sure):  # type: ignore[no-untyped-def]
    """The nearest of the points at each corner, a plane of corners after another; then the cubes between."""
    side, plane = SIDE, (SIDE + 1) ** 2
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
                            answer = UNSURE
                sure[((red - 1) * side + green) * side + blue] = answer


@compiled
def _linear(value):  # type: ignore[no-untyped-def]
    """Light of an sRGB value."""
    if value <= np.float32(0.04045):
        return value * np.float32(1 / 12.92)
    return ((value + np.float32(0.055)) * np.float32(1 / 1.055)) ** np.float32(2.4)


@compiled
def _nearest(red, green, blue, table, cones, lab):  # type: ignore[no-untyped-def]
    """The number of the nearest colour; the first of equal ones."""
    red, green, blue = _linear(red), _linear(green), _linear(blue)
    third = np.float32(1 / 3)
    long = (cones[0, 0] * red + cones[0, 1] * green + cones[0, 2] * blue) ** third
    medium = (cones[1, 0] * red + cones[1, 1] * green + cones[1, 2] * blue) ** third
    short = (cones[2, 0] * red + cones[2, 1] * green + cones[2, 2] * blue) ** third
    lightness = lab[0, 0] * long + lab[0, 1] * medium + lab[0, 2] * short
    a = lab[1, 0] * long + lab[1, 1] * medium + lab[1, 2] * short
    b = lab[2, 0] * long + lab[2, 1] * medium + lab[2, 2] * short
    nearest, least = 0, np.float32(1e9)
    for number in range(table.shape[1]):
        x, y, z = lightness - table[0, number], a - table[1, number], b - table[2, number]
        distance = x * x + y * y + z * z
        if distance < least:
            nearest, least = number, distance
    return nearest


@compiled
def _choose(colors, sure, table, cones, lab, lift, out):  # type: ignore[no-untyped-def]
    """The nearest colour of the palette: looked up, or where colours meet within a cube, computed."""
    zero, one, side = np.float32(0), np.float32(1), np.float32(64)
    number = np.int64(0)
    for i in range(colors.shape[0]):
        same = colors[i, 0] == colors[i - 1, 0] and colors[i, 1] == colors[i - 1, 1]
        if i > 0 and same and colors[i, 2] == colors[i - 1, 2]:  # as in large square pixels
            out[i, 0], out[i, 1], out[i, 2] = table[3, number], table[4, number], table[5, number]
            continue
        red = min(max(colors[i, 0] + lift, zero), one)
        green = min(max(colors[i, 1] + lift, zero), one)
        blue = min(max(colors[i, 2] + lift, zero), one)
        cube = (index_at(red * side, 63) * 64 + index_at(green * side, 63)) * 64 + index_at(blue * side, 63)
        number = np.int64(sure[cube])
        if number == 255:
            number = _nearest(red, green, blue, table, cones, lab)
        out[i, 0], out[i, 1], out[i, 2] = table[3, number], table[4, number], table[5, number]
