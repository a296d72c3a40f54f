"""Glyphs: a mosaic of characters."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Asset, LumaWeights, PageRegion, Raster, ResultRows, Slider, Switch, block
from vidstyle.blocks.pattern import read_tile
from vidstyle.blocks.pixelate import average_cells, cells_across, rows_for, whole_side
from vidstyle.core.kernels import compiled, interleaved
from vidstyle.core.marks.glyph_alphabet import (
    ZONE_COLUMNS,
    ZONE_COUNT,
    ZONE_ROWS,
    Alphabet,
    alphabet_from_tile,
    fit_to_cell,
    shapes_of,
)

TONE_WEIGHT = np.float32(6)
"""Weight of the square of a difference in tone, relative to the likeness of cell and glyph: the product of
their zones."""
MIN_DIFFERENCE_GAIN = np.float32(1e-4)
"""A later glyph is chosen only if it is more similar by this: mirrored glyphs are often equally similar."""
MIN_BRIGHTNESS = np.float32(0.1)
"""Darker colours are not raised to full brightness."""


def shipped_alphabets() -> dict[str, Path]:
    """Return the shipped alphabets by name (tools/tables/alphabet.py)."""
    return {file.stem: file for file in Path(__file__).with_name("alphabets").glob("*.png")}


def read_alphabet(path: Path) -> Alphabet:
    """Read glyphs from a PNG: side by side, white on black, each 3/5 as wide as it is high.

    Raises:
        ValueError: the file is not a PNG, is too large, or does not hold 2 or more glyphs that differ in
            tone.
        OSError: the file cannot be read.
    """
    return alphabet_from_tile(read_tile(path))


def _sides(cell: float) -> tuple[int, int]:
    """Return height and width of a cell in whole pixels, in the ratio 5 to 3; the width is even."""
    width = 2 * whole_side(cell / 2)
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
            "width of a glyph, rounded to even pixels",
            "px",
            explore=(5, 12),
            label="Letter size",
            max_detail=2.7,
            finest=8,
        ),
    ] = 8,
    invert: Annotated[bool, Switch("dark glyphs on white", label="Dark letters on white")] = False,
) -> np.ndarray:
    """Draw the picture in letters or signs; bright parts get denser ones.

    Each cell of the page holds the glyph of the most similar tone and shape: the more its two columns and
    three rows of zones differ, the more the shape counts, so edges become slashes, bars and dashes. The
    background is black. Glyphs are white if the picture is gray, else they have the cell's mean colour at
    full brightness, unless it is nearly black. Glyphs are averaged over each pixel, so they are smooth at
    any size.
    """
    (height, width), rows = _sides(cell), interleaved(picture)
    channels, count = rows.shape[1] // picture.shape[1], -(-picture.shape[1] // width)
    halves = cells_across(picture.shape[1], width // ZONE_COLUMNS, channels)
    line, means = rows_for(halves[1].size, width // ZONE_COLUMNS, channels)
    zones = np.empty((ZONE_ROWS, means.size), np.float32), np.empty(ZONE_ROWS, np.float32)
    chosen = np.empty(count, np.int32), np.empty((count, channels), np.float32)
    scratch = line, zones, np.empty(ZONE_COUNT, np.float32), *chosen
    page, step = (place.top, *place.margin), (height, width, channels)
    glyphs_ = shapes_of(alphabet), fit_to_cell(alphabet, height, width)
    _draw(rows, page, step, halves, scratch, weights, invert, glyphs_, interleaved(out))
    return out


@compiled(noalias=True)
def _draw(picture, page, step, halves, scratch, weights, invert, alphabet, out):  # type: ignore[no-untyped-def]
    """Draw the glyph of each cell, in the cell's colour.

    Args:
        page: the number of the first row on the page, and the numbers of margin rows above and below.
        halves: from `cells_across`, for halves of cells.
        scratch: a row, see `rows_for`; the means of the zones of a row of cells, and the rows of
            pixels in them; the lumas of the zones of a cell; the glyphs and the colours of a row of cells.
        alphabet: the shapes of glyphs, and glyphs in the size of a cell.
    """
    (top, above, below), (height, width, channels) = page, step
    (_, starts, counts), (line, (zones, shares), lumas, chosen, colors) = halves, scratch
    first, last, (shapes, glyphs_) = 0, picture.shape[0] - below, alphabet
    while first < last:
        end = min(first + height - (top + first) % height, picture.shape[0])
        begin = max(first, above)
        if begin < end:
            for zone in range(ZONE_ROWS):
                upper = min(first + -(-zone * height // ZONE_ROWS), end)
                lower = min(first + -(-(zone + 1) * height // ZONE_ROWS), end)
                shares[zone] = lower - upper
                if lower > upper:
                    rows, step_across = picture[upper:lower], (width // ZONE_COLUMNS, channels)
                    average_cells(rows, step_across, starts, counts, line, zones[zone])
            _choose(zones, (shares, counts), weights, invert, shapes, lumas, colors, chosen)
        for row in range(begin, min(end, last)):
            _draw_row(
                glyphs_[(top + row) % height :: height], width, chosen, colors, invert, out[row - above]
            )
        first = end


@compiled(noalias=True)
def _draw_row(rows, width, chosen, colors, invert, out):  # type: ignore[no-untyped-def]
    """Draw a row of pixels; `rows` has the row of each glyph."""
    base, sign = (np.float32(1), np.float32(-1)) if invert else (np.float32(0), np.float32(1))
    channels = colors.shape[1]
    for cell in range(chosen.size):
        shape, color, first = rows[chosen[cell]], colors[cell], width * cell
        for x in range(min(width, out.size // channels - first)):
            for channel in range(channels):
                out[channels * (first + x) + channel] = base + sign * shape[x] * color[channel]


@compiled
def _choose(zones, areas, weights, invert, shapes, lumas, colors, chosen):  # type: ignore[no-untyped-def]
    """Choose the glyphs of a row of cells, and their colours: the means at full brightness.

    Args:
        zones: rows of zones x means of halves of cells; zones beyond the page are not set.
        areas: rows of pixels in each row of zones, and pixels in a row of each mean.
    """
    (rows, counts), zero = areas, np.float32(0)
    channels = colors.shape[1]
    for cell in range(chosen.size):
        color, brightest, mean_luma = colors[cell], MIN_BRIGHTNESS, zero
        for channel in range(channels):
            mean, area = zero, zero
            for half in range(ZONE_COLUMNS):
                at = (ZONE_COLUMNS * cell + half) * channels + channel
                for zone in range(ZONE_ROWS):
                    if at < counts.size and rows[zone]:
                        mean += rows[zone] * counts[at] * zones[zone, at]
                        area += rows[zone] * counts[at]
            color[channel] = _shown(mean / area, invert)
            mean_luma += color[channel] if channels == 1 else weights[channel] * color[channel]
            brightest = max(brightest, color[channel])
        for zone in range(ZONE_ROWS):
            for half in range(ZONE_COLUMNS):
                at, luma = (ZONE_COLUMNS * cell + half) * channels, zero
                for channel in range(channels):
                    if at < counts.size and rows[zone]:
                        value = _shown(zones[zone, at + channel], invert)
                        luma += value if channels == 1 else weights[channel] * value
                lumas[ZONE_COLUMNS * zone + half] = luma if at < counts.size and rows[zone] else mean_luma
        for channel in range(channels):
            color[channel] /= brightest
        chosen[cell] = _most_similar(lumas, shapes)


@compiled
def _most_similar(lumas, shapes):  # type: ignore[no-untyped-def]
    zero, parts = np.float32(0), np.float32(ZONE_COUNT)
    number, tone, least = 0, lumas.sum() / parts, np.float32(np.inf)
    for glyph in range(shapes.shape[0]):
        cover, likeness = zero, zero
        for zone in range(ZONE_COUNT):
            cover += shapes[glyph, zone]
            likeness += (lumas[zone] - tone) * shapes[glyph, zone]
        change = tone - cover / parts
        difference = TONE_WEIGHT * change * change - likeness
        if difference < least - MIN_DIFFERENCE_GAIN:
            number, least = glyph, difference
    return number


@compiled
def _shown(mean, invert):  # type: ignore[no-untyped-def]
    level = min(max(mean, np.float32(0)), np.float32(1))
    return np.float32(1) - level if invert else level
