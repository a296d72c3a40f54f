"""Conversion between a picture's planes and working values, a band of rows at a time.

Working values are float32: luma and RGB 0..1, chroma -0.5..0.5 at luma's own resolution, all of
them gamma-encoded as the picture is; `RANGES` says how far they may leave that. Rows outside the picture
repeat the row at its edge.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from vidstyle.core.codes import Chroma, store
from vidstyle.core.kernels import compiled, gray_rgb, interleaved, is_gray
from vidstyle.core.kernels.weighing import Columns, Taps, weigh_rows, weigh_rows_and_columns
from vidstyle.core.picture import Encoding, Picture


def luma_rows(picture: Picture, top: int, bottom: int) -> np.ndarray:
    """Luma of the rows top..bottom as float32, new unless the picture holds just that; RGB is converted."""
    if picture.color is not None:
        return luma_from_rgb(color_rows(picture, top, bottom), picture.encoding)
    assert picture.luma is not None
    return decode_rows(picture.luma[top:bottom], "luma", picture.encoding)


def chroma_rows(picture: Picture, top: int, bottom: int) -> Chroma:
    """Blue and red difference of the rows, linearly interpolated to luma's resolution."""
    if picture.color is not None:
        _, blue, red = yuv_from_rgb(color_rows(picture, top, bottom), picture.encoding)
        return blue, red
    shape = bottom - top, picture.shape[1]
    if picture.chroma is None:
        return np.zeros(shape, np.float32), np.zeros(shape, np.float32)
    return upsample_chroma(picture.chroma, picture.encoding, top, shape)


def stored_chroma_rows(picture: Picture, top: int, bottom: int) -> Chroma:
    """Rows of the chroma planes themselves, on the grid that they have, as float32."""
    assert picture.chroma is not None
    blue, red = (decode_rows(each[top:bottom], "chroma", picture.encoding) for each in picture.chroma)
    return blue, red


def upsample_chroma(chroma: Chroma, encoding: Encoding, top: int, shape: tuple[int, int]) -> Chroma:
    """Chroma at luma's resolution from planes on the encoding's grid, by linear interpolation.

    Args:
        chroma: the whole planes.
        encoding: grid and codes of the planes.
        top: the first luma row.
        shape: rows and columns of luma.
    """
    neutral, span = encoding.chroma_levels
    (across, down), (x, y) = encoding.subsampling, encoding.siting
    first, weights = _between(shape[0], down, y, top)
    rows, offset = (first, weights / np.float32(span)), np.float32(-neutral / span)
    blue, red = np.empty(shape, np.float32), np.empty(shape, np.float32)
    if across == 2 and 0 <= x <= 1:
        line = np.empty(chroma[0].shape[1] + 2, np.float32)
        _lerp_both(*chroma, *rows, offset, np.float32(x / 2), line, blue, red)
        return blue, red
    columns = Columns.of(_between(shape[1], across, x, 0), chroma[0].shape[1])
    for plane, out in zip(chroma, (blue, red), strict=True):
        weigh_rows_and_columns(plane, rows, columns, out)
        out += offset
    return blue, red


def color_rows(picture: Picture, top: int, bottom: int) -> np.ndarray:
    """RGB of the rows, N x W x 3 float32; values outside 0..1 are kept."""
    if picture.color is None:
        luma = luma_rows(picture, top, bottom)
        if picture.chroma is None:
            return gray_rgb(luma)
        return rgb_from_yuv(luma, chroma_rows(picture, top, bottom), picture.encoding)
    return decode_rows(picture.color[top:bottom], "color", picture.encoding)


def rgb_from_yuv(luma: np.ndarray, chroma: Chroma, encoding: Encoding) -> np.ndarray:
    """RGB, N x W x 3 float32, of three N x W float32 planes."""
    color = np.empty((*luma.shape, 3), np.float32)
    _mix_rgb(luma, *chroma, encoding.to_rgb, interleaved(color))
    return color


def yuv_from_rgb(color: np.ndarray, encoding: Encoding) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Luma, blue and red difference, three N x W float32 planes."""
    luma, blue, red = (np.empty(color.shape[:2], np.float32) for _ in range(3))
    _mix_yuv(interleaved(color), encoding.from_rgb, luma, blue, red)
    return luma, blue, red


def luma_from_rgb(color: np.ndarray, encoding: Encoding, out: np.ndarray | None = None) -> np.ndarray:
    """Luma of `yuv_from_rgb` alone, in `out` if that is given."""
    luma = np.empty(color.shape[:2], np.float32) if out is None else out
    if is_gray(color):
        luma[:] = color[:, :, 0]
    else:
        _mix_luma(interleaved(color), encoding.from_rgb, luma)
    return luma


def alpha_in_depth(source: Picture, depth: int) -> np.ndarray | None:
    """Return the picture's alpha in another depth; itself where it has that."""
    if source.alpha is None or source.encoding.depth == depth:
        return source.alpha
    old, new = (Encoding(full_range=True, depth=each) for each in (source.encoding.depth, depth))
    out = np.empty(source.alpha.shape, new.dtype)
    values = np.multiply(source.alpha, np.float32(1 / old.luma_levels[1]), dtype=np.float32)
    store(values, *new.luma_levels, depth, out)
    return out


def stored_planes(picture: Picture, kind: str) -> tuple[np.ndarray, ...]:
    """Return the planes with luma, chroma or RGB of a picture; none if it has other planes.

    Args:
        kind: "luma", "chroma" or "color".
    """
    if kind == "chroma":
        return picture.chroma or ()
    plane = picture.luma if kind == "luma" else picture.color
    return () if plane is None else (plane,)


def decode_rows(codes: np.ndarray, kind: str, encoding: Encoding) -> np.ndarray:
    """Return rows of a plane as working values, float32; the rows themselves if they are working values.

    Args:
        codes: stored codes, or averages of them.
        kind: of the plane: "luma", "chroma" or "color".
    """
    if encoding.depth == 0:
        return codes
    black, white = encoding.luma_levels
    zero, span = encoding.chroma_levels if kind == "chroma" else (black, white - black)
    out = np.empty(codes.shape, np.float32)
    _decode(interleaved(codes), np.float32(1 / span), np.float32(zero / span), interleaved(out))
    return out


@lru_cache(maxsize=256)
def _between(count: int, step: int, siting: float, first: int) -> Taps:
    """Return the two samples around each of `count` luma positions, and their weights."""
    if step == 1:
        position = np.arange(first, first + count, dtype=np.float64)
    else:
        position = (np.arange(first, first + count) - siting) / step
    below = np.floor(position).astype(np.int64)
    part = position - below
    return below, np.stack([1 - part, part], axis=1).astype(np.float32)


@compiled
def _decode(codes, gain, offset, out):  # type: ignore[no-untyped-def]
    for row in range(out.shape[0]):
        for x in range(out.shape[1]):
            out[row, x] = np.float32(codes[row, x]) * gain - offset


@compiled
def _lerp_both(blue, red, first, weights, offset, part, line, blue_out, red_out):  # type: ignore[no-untyped-def]
    _lerp(blue, first, weights, offset, part, line, blue_out)
    _lerp(red, first, weights, offset, part, line, red_out)


@compiled
def _lerp(plane, first, weights, offset, part, line, out):  # type: ignore[no-untyped-def]
    """Weighted sums of rows, made twice as wide."""
    samples = plane.shape[1]
    for row in range(out.shape[0]):
        weigh_rows(plane, plane.shape[0], first[row], weights[row], line[1 : samples + 1])
        line[0], line[samples + 1] = line[1], line[samples]
        _double(line, part, offset, out[row])


@compiled(noalias=True)
def _double(line, part, offset, out):  # type: ignore[no-untyped-def]
    """An even pixel lies `part` of a sample before its own one, an odd one behind it."""
    behind = np.float32(0.5) - part
    for x in range(out.size // 2):
        here = line[x + 1] + offset
        out[2 * x] = here + part * (line[x] + offset - here)
        out[2 * x + 1] = here + behind * (line[x + 2] + offset - here)
    if out.size % 2:
        here = line[out.size // 2 + 1] + offset
        out[out.size - 1] = here + part * (line[out.size // 2] + offset - here)


@compiled
def _mix_rgb(luma, blue, red, matrix, out):  # type: ignore[no-untyped-def]
    from_red, green_blue, green_red, from_blue = matrix[0, 2], matrix[1, 1], matrix[1, 2], matrix[2, 1]
    for row in range(luma.shape[0]):
        for x in range(luma.shape[1]):
            y, u, v = luma[row, x], blue[row, x], red[row, x]
            out[row, 3 * x] = y + from_red * v
            out[row, 3 * x + 1] = y + green_blue * u + green_red * v
            out[row, 3 * x + 2] = y + from_blue * u


@compiled
def _mix_luma(color, matrix, luma):  # type: ignore[no-untyped-def]
    luma_red, luma_green, luma_blue = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    for row in range(luma.shape[0]):
        for x in range(luma.shape[1]):
            r, g, b = color[row, 3 * x], color[row, 3 * x + 1], color[row, 3 * x + 2]
            luma[row, x] = luma_red * r + luma_green * g + luma_blue * b


@compiled
def _mix_yuv(color, matrix, luma, blue, red):  # type: ignore[no-untyped-def]
    luma_red, luma_green, luma_blue = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    blue_red, blue_green, blue_blue = matrix[1, 0], matrix[1, 1], matrix[1, 2]
    red_red, red_green, red_blue = matrix[2, 0], matrix[2, 1], matrix[2, 2]
    for row in range(luma.shape[0]):
        for x in range(luma.shape[1]):
            r, g, b = color[row, 3 * x], color[row, 3 * x + 1], color[row, 3 * x + 2]
            luma[row, x] = luma_red * r + luma_green * g + luma_blue * b
            blue[row, x] = blue_red * r + blue_green * g + blue_blue * b
            red[row, x] = red_red * r + red_green * g + red_blue * b
