"""Palette: the nearest of a few colours."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Asset, block, rgb_from_text
from vidstyle.core.kernels import TIE_LIFT, cached, compiled, index_at
from vidstyle.core.regular_file import read_regular_file

MAX_COLORS = 64
MAX_FILE_BYTES = 4096

SIDE = 64
"""Cubes along each side of the table that knows most answers."""
UNSURE = 255
"""In this table: more than one colour is the nearest within the cube."""

TO_CONES = np.array(
    [
        [0.4122214708, 0.5363325363, 0.0514459929],
        [0.2119034982, 0.6806995451, 0.1073969566],
        [0.0883024619, 0.2817188376, 0.6299787005],
    ]
)
TO_LAB = np.array(
    [
        [0.2104542553, 0.7936177850, -0.0040720468],
        [1.9779984951, -2.4285922050, 0.4505937099],
        [0.0259040371, 0.7827717662, -0.8086757660],
    ]
)
"""OKLab: Ottosson 2020, "A perceptual color space for image processing"."""


def shipped_palettes() -> dict[str, Path]:
    """The palettes that come with vidstyle, by name."""
    return {file.stem: file for file in Path(__file__).with_name("palettes").glob("*.txt")}


def read_palette(path: Path) -> tuple[np.ndarray]:
    """The colours of a text file, one `#rrggbb` a line.

    Returns:
        One table, 6 x colours float32: their OKLab, and red, green and blue 0..1.

    Raises:
        ValueError: a line is not a colour, or there are not 2 to 64.
        OSError: it cannot be read.
    """
    lines = read_regular_file(path, MAX_FILE_BYTES).decode("ascii", "replace").split()
    if wrong := next((line for line in lines if not re.fullmatch("#[0-9a-fA-F]{6}", line)), None):
        raise ValueError(f"{wrong[:16]!r} is not #rrggbb")
    if not 2 <= len(lines) <= MAX_COLORS:
        raise ValueError(f"needs 2 to {MAX_COLORS} colours, has {len(lines)}")
    colors = np.array([rgb_from_text(line) for line in lines])
    lab = TO_LAB @ np.cbrt(TO_CONES @ _light(colors.T))
    return (np.vstack([lab, colors.T]).astype(np.float32),)


@block("pixel", on="color")
def palette(
    picture: np.ndarray,
    colors: Annotated[
        Any, Asset("name of a palette, or a text file of #rrggbb lines", read_palette, shipped_palettes)
    ] = "ember",
) -> np.ndarray:
    """Replace each colour by the nearest of a palette of 2 to 64, in OKLab.

    `dither` before it mixes them. Ottosson 2020, "A perceptual color space for image processing".
    """
    (table,) = colors
    out = np.empty(picture.shape, np.float32)
    sure = _sure_answers(table.tobytes())
    cones, lab = TO_CONES.astype(np.float32), TO_LAB.astype(np.float32)
    _choose(picture.reshape(-1, 3), sure, table, cones, lab, TIE_LIFT, out.reshape(-1, 3))
    return out


def _light(values: np.ndarray) -> np.ndarray:
    """Light of sRGB values, 0..1."""
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


@cached(maxsize=4)
def _sure_answers(table: bytes) -> np.ndarray:
    """For each cube of colours the nearest of the palette if all its corners share it: SIDE ** 3 uint8."""
    points = np.frombuffer(table, np.float32).reshape(6, -1)[:3].astype(np.float64)
    light = _light(np.arange(SIDE + 1) / SIDE)
    flat = light[:, None, None] * TO_CONES[:, 1] + light[:, None] * TO_CONES[:, 2]
    corners = np.empty((SIDE + 1,) * 3, np.uint8)
    for red, plane in zip(light, corners, strict=True):  # plane by plane, for the sake of memory
        lab = np.cbrt(flat + red * TO_CONES[:, 0]) @ TO_LAB.T
        # The square of the corner's own length is the same for all.
        plane[:] = ((points * points).sum(axis=0) - 2 * (lab @ points)).argmin(axis=2)
    first, last = corners, corners
    for axis in range(3):
        low, high = slice(None, -1), slice(1, None)
        before, after = ((slice(None),) * axis + (side,) for side in (low, high))
        first, last = np.minimum(first[before], first[after]), np.maximum(last[before], last[after])
    return np.where(first == last, first, np.uint8(UNSURE)).reshape(-1)


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
