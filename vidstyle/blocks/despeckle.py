"""Despeckle: removes marks that are short in every direction."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated

import numpy as np

from vidstyle.block import Margin, ResultRows, Slider, block
from vidstyle.core.kernels import compiled

HALF_STEPS = (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (-1, 2), (-2, 2), (-2, 1)
"""Half of a step in each direction, to the right and down; see the shader."""
POINT_COUNT = 6
"""Pixels that are read on each side of the middle of a line, at equal distances."""
MAX_LUMA = np.float32(1e9)
"""More than any luma; as in the shader."""
TILE_SIZE = 512
"""Numbers of a row that form a tile: its scratch rows stay in the first-level cache."""


def _reach(length: float) -> int:
    return max(math.floor(length - 0.5), 0)


@block(
    "filter",
    on="luma",
    radius=_reach,
    label="Remove specks",
    category="smooth",
    aliases=(
        "specks, spots, dust, gravel, sand, grain, salt and pepper, denoise, clean, dots, grass, "
        "morphology, opening, closing"
    ),
)
def despeckle(
    luma: np.ndarray,
    margin: Margin,
    out: ResultRows,
    length: Annotated[
        float,
        Slider(1, 24, "dark and bright marks shorter than this disappear", "px", label="Longest speck"),
    ] = 9,
    contrast: Annotated[
        float,
        Slider(
            1,
            255,
            "specks with more contrast than this stay, such as letters and windows",
            "of 255",
            label="Strongest speck",
        ),
    ] = 50,
) -> np.ndarray:
    """Remove small dark and bright specks, and keep lines, corners and strong marks.

    Morphological closing and opening by lines in eight directions: a dark mark stays where a line of this
    length in any direction, which begins, ends or has its middle at the pixel, is dark; likewise a bright
    one. The difference d that this makes is divided by 1 + (d / c)^4, with c the contrast. Soille and Talbot
    2001, "Directional morphological filtering".
    """
    reach = _reach(length)
    if reach == 0:
        return luma
    around = np.pad(luma, reach, "edge")
    width = around.shape[1]
    first = (reach + margin[0]) * width + reach
    scratch = np.empty((2, TILE_SIZE), np.float32)
    per_contrast = np.float32(255 / contrast)
    _keep_lines(around.reshape(-1), width, _offsets(reach, width), first, per_contrast, scratch, out)
    return out


@lru_cache(maxsize=64)
def _offsets(reach: int, width: int) -> np.ndarray:
    """Return what to add to the index of a pixel for each point of each line, in rows of `width` numbers.

    Returns:
        8 x 2 `POINT_COUNT`: the points ahead, nearest first, then those behind.
    """
    numbers = [sign * number for sign in (1, -1) for number in range(1, POINT_COUNT + 1)]
    offsets = []
    for right, down in HALF_STEPS:
        steps = math.floor(reach / (math.hypot(right, down) / 2) + 0.5)
        across, below = ([_point(number * steps * part) for number in numbers] for part in (right, down))
        offsets.append([y * width + x for x, y in zip(across, below, strict=True)])
    return np.array(offsets, np.int32)


def _point(part: int) -> int:
    """Return the nearest whole step of half a step times all points."""
    return math.floor((part + POINT_COUNT + 0.5) / (2 * POINT_COUNT))


@compiled(fastmath=True, noalias=True)
def _keep_lines(flat, width, offsets, first, per_contrast, scratch, out):  # type: ignore[no-untyped-def]
    """Write all rows of the result, in tiles.

    Args:
        flat: the rows of the picture, each of `width` numbers.
        offsets: from `_offsets`.
        first: the index of the first pixel of the result.
        per_contrast: 1 / contrast.
        scratch: two rows of a tile.
    """
    for row in range(out.shape[0]):
        for begin in range(0, out.shape[1], TILE_SIZE):
            end, here = min(begin + TILE_SIZE, out.shape[1]), first + row * width + begin
            own, drawn = flat[here:], out[row, begin:end]
            dark, bright = scratch[0][: drawn.size], scratch[1][: drawn.size]
            for x in range(drawn.size):
                dark[x], bright[x] = MAX_LUMA, -MAX_LUMA
            for number in range(offsets.shape[0]):
                _keep_line(flat, here, offsets[number], dark, bright)
            for x in range(drawn.size):
                change = dark[x] + bright[x] - np.float32(2) * own[x]
                relative = per_contrast * change
                squared = relative * relative
                drawn[x] = own[x] + change / (np.float32(1) + squared * squared)


@compiled(fastmath=True, noalias=True)
def _keep_line(flat, here, offsets, dark, bright):  # type: ignore[no-untyped-def]
    """Add one direction: lines that end, begin or have their middle at each pixel.

    `dark` is the least of the maxima along them, `bright` the greatest of the minima.
    """
    own = flat[here:]
    a, b, c = flat[here + offsets[0] :], flat[here + offsets[1] :], flat[here + offsets[2] :]
    d, e, f = flat[here + offsets[3] :], flat[here + offsets[4] :], flat[here + offsets[5] :]
    p, q, r = flat[here + offsets[6] :], flat[here + offsets[7] :], flat[here + offsets[8] :]
    s, t, u = flat[here + offsets[9] :], flat[here + offsets[10] :], flat[here + offsets[11] :]
    for x in range(dark.size):
        ahead = max(max(own[x], a[x]), max(b[x], c[x]))
        behind = max(max(own[x], p[x]), max(q[x], r[x]))
        middle = max(ahead, behind)
        ahead, behind = max(max(ahead, d[x]), max(e[x], f[x])), max(max(behind, s[x]), max(t[x], u[x]))
        dark[x] = min(min(dark[x], middle), min(ahead, behind))
        ahead = min(min(own[x], a[x]), min(b[x], c[x]))
        behind = min(min(own[x], p[x]), min(q[x], r[x]))
        middle = min(ahead, behind)
        ahead, behind = min(min(ahead, d[x]), min(e[x], f[x])), min(min(behind, s[x]), min(t[x], u[x]))
        bright[x] = max(max(bright[x], middle), max(ahead, behind))
