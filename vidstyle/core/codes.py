"""Converts working values to the codes of planes: luma, RGB, and chroma averaged over each sample's area.

The area is a box of one chroma step centred on the sample, the classic filter of each siting: two equal
weights between pixels, 1-2-1 on a pixel. Outside the picture its edge is repeated.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any

import numpy as np

from vidstyle.core.color.deferred_color import NO_LAYERS, Printed, lay_on
from vidstyle.core.kernels import compiled, interleaved
from vidstyle.core.picture import Encoding

Chroma = tuple[np.ndarray, np.ndarray]
SampleArea = tuple[int, int, np.ndarray]
"""Along one axis: luma pixels for each sample, the first pixel under the first one, and weights."""

Levels = tuple[np.float32, np.float32, np.float32]
"""The factor of values, the offset that is added, and the highest code."""

IDENTITY_MIX_WEIGHTS = np.eye(3, 2, dtype=np.float32)
"""The mix of two planes that are blue and red difference already."""


def store(values: np.ndarray, black: float, white: float, depth: int, out: np.ndarray) -> None:
    """Write float32 values as integers: 0 becomes `black`, 1 becomes `white`, halves are rounded up.

    So are values that rounding has left slightly below a half. Clips to `depth` bits; depth 0 copies.
    """
    if depth == 0:
        np.copyto(out, values)
    else:
        _store(values, _levels(black, white - black, depth), out)


def store_chroma(
    planes: tuple[np.ndarray, ...], mix: np.ndarray, above: int, encoding: Encoding, chroma: Chroma
) -> None:
    """Write chroma at luma's resolution as samples of an encoding.

    Args:
        planes: N x W float32 rows of the page.
        mix: the weight of each plane in blue and in red difference; the last row is added to both; float32.
        above: how many rows lie above the band, which starts at a multiple of the step.
        chroma: rows of blue and red difference, written, for the band.
    """
    rows, columns, encode, _, levels = _sampling(encoding)
    lines = _lines(planes[0].shape[1], columns)
    if len({plane.flags.c_contiguous for plane in planes}) > 1:  # the kernel takes planes of one type
        planes = tuple(map(np.ascontiguousarray, planes))
    _store_chroma(planes, mix, above, rows, columns, lines, encode, levels, *chroma)


def store_yuv(
    color: np.ndarray | Printed, above: int, encoding: Encoding, luma: np.ndarray, chroma: Chroma
) -> None:
    """Write RGB as luma and chroma of an encoding.

    Args:
        color: N x W x 3 float32 rows of the page.
        above: how many rows lie above the band, which starts at a multiple of the chroma step.
        luma: rows, written, for the band.
        chroma: rows of blue and red difference, written, for the band.
    """
    rows, columns, encode, luma_levels, levels = _sampling(encoding)
    lines, outside = _lines(luma.shape[1], columns), np.empty_like(luma[0])
    cover, tones = color.layers if isinstance(color, Printed) else NO_LAYERS
    color = interleaved(color.color if isinstance(color, Printed) else color)
    printed = np.empty(color.shape[1], np.float32)
    _store_yuv(
        color, cover, tones, printed, encoding.from_rgb, above, rows, columns, lines,
        outside, encode, luma_levels, levels, luma, *chroma,
    )  # fmt: skip


def chroma_radius(encoding: Encoding, axis: int = 1) -> tuple[int, int]:
    """Return how many rows above and below a band of whole chroma rows its samples average over.

    Args:
        axis: 0 for columns left and right instead.
    """
    step, offset = encoding.subsampling[axis], encoding.siting[axis]
    if step == 1:
        return 0, 0
    above, below = step / 2 - 0.5 - offset, offset + 0.5 - step / 2
    return max(math.ceil(above), 0), max(math.ceil(below), 0)


@lru_cache(maxsize=64)
def _sampling(encoding: Encoding) -> tuple[SampleArea, SampleArea, Any, Levels, Levels]:
    """Return the areas down and across, the kernel that makes codes, and its levels for luma and chroma."""
    columns, rows = (_area(*each) for each in zip(encoding.subsampling, encoding.siting, strict=True))
    black, white = encoding.luma_levels
    levels = _levels(black, white - black, encoding.depth), _levels(*encoding.chroma_levels, encoding.depth)
    return rows, columns, _rounded if encoding.depth else _unchanged, *levels


def _levels(zero: float, span: float, depth: int) -> Levels:
    return np.float32(span), np.float32(zero), np.float32(2**depth - 1)


def _lines(width: int, columns: SampleArea) -> np.ndarray:
    """Scratch for `_store_samples`: blue and red difference."""
    return np.empty((2, width + 3 * columns[0]), np.float32)


def _area(step: int, siting: float) -> SampleArea:
    if step == 1:
        return 1, 0, np.ones(1, np.float32)
    first = math.floor(siting - step / 2 + 0.5)
    pixels = np.arange(first, first + step + 1)
    low, high = np.maximum(pixels - 0.5, siting - step / 2), np.minimum(pixels + 0.5, siting + step / 2)
    return step, first, (np.maximum(high - low, 0) / step).astype(np.float32)


@compiled
def _rounded(value, levels):  # type: ignore[no-untyped-def]
    # Means of a few 8-bit codes often end in one half. Rounding of a sum, or of a GPU's 16-bit textures
    # (0.0026 codes), must not decide there: results would differ by a level.
    code = value * levels[0] + levels[1] + np.float32(0.503)
    return np.int32(min(max(code, np.float32(0)), levels[2]))  # vectors have no other whole numbers of floats


@compiled
def _unchanged(value, levels):  # type: ignore[no-untyped-def]
    return value


@compiled
def _store(values, levels, out):  # type: ignore[no-untyped-def]
    for row in range(out.shape[0]):
        _encode(values[row], _rounded, levels, out[row])


@compiled(noalias=True)
def _store_chroma(planes, mix, above, rows, columns, lines, encode, levels, blue, red):  # type: ignore[no-untyped-def]
    (down, first, weights), across = rows, columns[0]
    height, width = planes[0].shape
    for row in range(blue.shape[0]):
        for line in range(2):
            own = lines[line, across : across + width]
            own[:] = mix[len(planes), line]
            for number in range(len(planes)):
                for tap in range(weights.size):
                    part = mix[number, line] * weights[tap]
                    if part != 0:
                        source = min(max(above + first + down * row + tap, 0), height - 1)
                        _add(part, planes[number][source], own)
        _store_samples(lines[0], columns, encode, levels, blue[row])
        _store_samples(lines[1], columns, encode, levels, red[row])


@compiled(noalias=True)
def _store_yuv(  # type: ignore[no-untyped-def]
    color,
    cover,
    tones,
    printed,
    matrix,
    above,
    rows,
    columns,
    lines,
    outside,
    encode,
    luma_levels,
    levels,
    luma,
    blue,
    red,
):
    """For each chroma row its own luma rows, and the others that its samples average over.

    Args:
        cover, tones: `Printed.layers`, or no rows.
        printed: scratch, a row of RGB.
        outside: scratch for luma of those others.
    """
    (down, first, weights), across = rows, columns[0]
    height, width = luma.shape
    blue_line, red_line = lines[0, across : across + width], lines[1, across : across + width]
    for row in range(blue.shape[0]):
        blue_line[:] = 0
        red_line[:] = 0
        for each in range(min(first, 0), max(first + weights.size, down)):
            place, tap = down * row + each, each - first
            part = weights[tap] if 0 <= tap < weights.size else np.float32(0)
            is_own = 0 <= each < down and place < height
            if is_own or part != 0:
                number = min(max(above + place, 0), color.shape[0] - 1)
                source = color[number]
                if cover.size:
                    lay_on(source, cover[min(number, cover.shape[0] - 1)], tones, printed)
                    source = printed
                own = luma[place] if is_own else outside
                _add_yuv(source, matrix, part, encode, luma_levels, own, blue_line, red_line)
        _store_samples(lines[0], columns, encode, levels, blue[row])
        _store_samples(lines[1], columns, encode, levels, red[row])


@compiled(noalias=True)
def _add(part, values, out):  # type: ignore[no-untyped-def]
    for x in range(out.size):
        out[x] += part * values[x]


@compiled(fastmath=True, noalias=True)
def _add_yuv(color, matrix, part, encode, levels, luma, blue, red):  # type: ignore[no-untyped-def]
    luma_red, luma_green, luma_blue = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    blue_red, blue_green, blue_blue = matrix[1, 0], matrix[1, 1], matrix[1, 2]
    red_red, red_green, red_blue = matrix[2, 0], matrix[2, 1], matrix[2, 2]
    for x in range(luma.size):
        r, g, b = color[3 * x], color[3 * x + 1], color[3 * x + 2]
        luma[x] = encode(luma_red * r + luma_green * g + luma_blue * b, levels)
        blue[x] += part * (blue_red * r + blue_green * g + blue_blue * b)
        red[x] += part * (red_red * r + red_green * g + red_blue * b)


@compiled
def _store_samples(line, columns, encode, levels, out):  # type: ignore[no-untyped-def]
    """Average over columns.

    Args:
        line: the values, after one step and before two steps of scratch, in which the edge is repeated.
    """
    across, first, weights = columns
    last = line.size - 2 * across
    for x in range(across):
        line[x] = line[across]
    for x in range(last, line.size):
        line[x] = line[last - 1]
    values = line[across + first :]
    if across == 1:
        _encode(values, encode, levels, out)
    elif across == 2:
        _encode_halved(values, weights, encode, levels, out)
    else:
        for x in range(out.size):
            total = np.float32(0)
            for tap in range(weights.size):
                total += weights[tap] * values[across * x + tap]
            out[x] = encode(total, levels)


@compiled(noalias=True)
def _encode(values, encode, levels, out):  # type: ignore[no-untyped-def]
    for x in range(out.size):
        out[x] = encode(values[x], levels)


@compiled(noalias=True)
def _encode_halved(values, weights, encode, levels, out):  # type: ignore[no-untyped-def]
    left, middle, right = weights[0], weights[1], weights[2]
    for x in range(out.size):
        out[x] = encode(left * values[2 * x] + middle * values[2 * x + 1] + right * values[2 * x + 2], levels)
