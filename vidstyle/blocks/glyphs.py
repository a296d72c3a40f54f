"""Glyphs: a mosaic of characters."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Asset, LumaWeights, PageRegion, Raster, ResultRows, Slider, Switch, block
from vidstyle.blocks.pattern import read_tile
from vidstyle.blocks.pixelate import average_cells, cells_across, rows_for, whole_side
from vidstyle.core.kernels import TIE_LIFT, cached, compiled, interleaved, look_up_at

MIN_BRIGHTNESS = np.float32(0.1)
"""Darker colours are not raised to full brightness."""


def shipped_alphabets() -> dict[str, Path]:
    """Return the shipped alphabets by name (tools/tables/alphabet.py)."""
    return {file.stem: file for file in Path(__file__).with_name("alphabets").glob("*.png")}


class Alphabet(tuple[np.ndarray]):
    """A table, float32 0..1; compared by identity.

    It holds the glyphs side by side, sorted by increasing coverage. The last row holds the lowest tone of
    each glyph, in the column of the glyph's number.
    """

    __eq__, __hash__ = object.__eq__, object.__hash__


def read_alphabet(path: Path) -> Alphabet:
    """Read glyphs from a PNG: side by side, white on black, each 3/5 as wide as it is high.

    Raises:
        ValueError: the file is not a PNG, is too large, or does not hold 2 or more glyphs that differ in
            tone.
        OSError: the file cannot be read.
    """
    tile = read_tile(path)
    height, columns = tile.shape
    width = height * 3 // 5
    count = columns // max(width, 1)
    if height % 5 or columns % max(width, 1) or count < 2:
        raise ValueError("needs 2 or more glyphs side by side, each 3/5 as wide as it is high")
    glyphs = tile.reshape(height, count, width).transpose(1, 0, 2)
    cover = glyphs.mean(axis=(1, 2))
    order = np.argsort(cover, kind="stable")
    cover = cover[order]
    if cover[-1] <= cover[0]:
        raise ValueError("has glyphs of only one tone")
    tones = np.zeros((1, columns), np.float32)
    tones[0, 1:count] = ((cover[1:] + cover[:-1]) / 2 - cover[0]) / (cover[-1] - cover[0])
    return Alphabet([np.vstack([np.hstack(list(glyphs[order])), tones])])


def _sides(cell: float) -> tuple[int, int]:
    """Return height and width of a cell in whole pixels, in the ratio 5 to 3."""
    width = whole_side(cell)
    return (10 * width + 3) // 6, width


@block(
    "filter",
    on="channels",
    radius=lambda cell: max(_sides(cell)) - 1,
    raster=lambda cell: Raster.of_cells(*_sides(cell)),
    label="Letters",
    category="print",
    aliases="ascii, text, characters, font, typewriter, terminal, matrix, emoji",
)
def glyphs(
    picture: np.ndarray,
    place: PageRegion,
    weights: LumaWeights,
    out: ResultRows,
    alphabet: Annotated[
        Any,
        Asset(
            "name of an alphabet, or a .png of glyphs side by side",
            read_alphabet,
            shipped_alphabets,
            label="Alphabet",
        ),
    ] = "letters",
    cell: Annotated[
        float,
        Slider(
            3,
            64,
            "width of a glyph, rounded to whole pixels",
            "px",
            explore=(5, 12),
            label="Letter size",
            max_detail=2,
            finest=8,
        ),
    ] = 8,
    invert: Annotated[bool, Switch("dark glyphs on white", label="Dark letters on white")] = False,
) -> np.ndarray:
    """Draw the picture in letters or signs; bright parts get denser ones.

    Each cell of the page holds one glyph, whose coverage matches its brightness. The background is black.
    Glyphs are white if the picture is gray, else they have the cell's mean colour at full brightness,
    unless it is nearly black. Glyphs are averaged over each pixel, so they are smooth at any size.
    """
    (table,), (height, width), rows = alphabet, _sides(cell), interleaved(picture)
    channels = rows.shape[1] // picture.shape[1]
    cells = cells_across(picture.shape[1], width, channels)
    line, means = rows_for(cells[1].size, width, channels)
    tones = table[-1, : 5 * table.shape[1] // (3 * (table.shape[0] - 1))]
    glyphs_ = tones, _fit_to_cell(alphabet, height, width)
    drawn = np.empty(rows.shape[1] // channels, np.int32), np.empty(rows.shape[1], np.float32)
    page, step = (place.top, *place.margin), (height, width, channels)
    _draw(rows, page, step, *cells, line, means, weights, invert, *glyphs_, *drawn, interleaved(out))
    return out


@compiled(noalias=True)
def _draw(  # type: ignore[no-untyped-def]
    picture, page, step, owners, starts, counts, line, means, weights, invert, tones, glyphs_, places, colors,
    out,
):  # fmt: skip
    """Draw the glyph of each cell, in the cell's colour.

    Args:
        page: the number of the first row on the page, and the numbers of margin rows above and below.
        places, colors: scratch: for each pixel of a row its index in the first row of its glyph, and its
            colour.
    """
    (top, above, below), (height, width, channels) = page, step
    first, last = 0, picture.shape[0] - below
    while first < last:
        end = min(first + height - (top + first) % height, picture.shape[0])
        begin = max(first, above)
        if begin < end:
            average_cells(picture[first:end], (width, channels), starts, counts, line, means)
            _choose(means, weights, invert, tones, (width, glyphs_.size // tones.size), places)
            for x in range(colors.size):
                colors[x] = means[look_up_at(owners[x])]
        for row in range(begin, min(end, last)):
            shape = glyphs_[(top + row) % height * width :]
            _draw_row(shape, places, colors, invert, out[row - above])
        first = end


@compiled(noalias=True)
def _draw_row(shape, places, colors, invert, out):  # type: ignore[no-untyped-def]
    base, sign = (np.float32(1), np.float32(-1)) if invert else (np.float32(0), np.float32(1))
    if out.size == places.size:
        for x in range(out.size):
            out[x] = base + sign * shape[look_up_at(places[x])] * colors[x]
    else:
        for x in range(places.size):
            i, j, k, cover = 3 * x, 3 * x + 1, 3 * x + 2, sign * shape[look_up_at(places[x])]
            out[i] = base + cover * colors[i]
            out[j] = base + cover * colors[j]
            out[k] = base + cover * colors[k]


@compiled
def _choose(means, weights, invert, tones, sizes, places):  # type: ignore[no-untyped-def]
    """Choose the glyphs of a row of cells, and raise their means to full brightness in place.

    Args:
        sizes: number of values in a row of a glyph, and in a glyph.
    """
    (width, area), zero, one = sizes, np.float32(0), np.float32(1)
    count = -(-places.size // width)
    channels = means.size // count
    for cell in range(count):
        color, luma, brightest = means[channels * cell : channels * (cell + 1)], zero, MIN_BRIGHTNESS
        for channel in range(channels):
            mean = min(max(color[channel], zero), one)
            color[channel] = one - mean if invert else mean
            luma += color[channel] if channels == 1 else weights[channel] * color[channel]
            brightest = max(brightest, color[channel])
        for channel in range(channels):
            color[channel] /= brightest
        glyph = 0
        while glyph + 1 < tones.size and tones[glyph + 1] <= luma + TIE_LIFT:
            glyph += 1
        for x in range(width * cell, min(width * (cell + 1), places.size)):
            places[x] = glyph * area + x - width * cell


@cached(maxsize=4)
def _fit_to_cell(alphabet: Alphabet, height: int, width: int) -> np.ndarray:
    """Average the glyphs over the pixels of a cell: float32, each height x width, in one flat array."""
    strip = alphabet[0][:-1]
    slim = len(strip) * 3 // 5
    drawn = strip.reshape(len(strip), -1, slim).transpose(1, 0, 2).astype(np.float64)
    return (_shares(height, len(strip)) @ drawn @ _shares(width, slim).T).astype(np.float32).reshape(-1)


def _shares(pixels: int, parts: int) -> np.ndarray:
    """Return the share of each pixel that each part of a side covers, pixels x parts."""
    edges = np.arange(pixels + 1)[:, None] * parts / pixels - np.arange(parts)
    passed = np.clip(edges, 0, 1)
    return np.diff(passed, axis=0) * pixels / parts
