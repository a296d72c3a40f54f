"""Glyphs: a mosaic of characters."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Asset, LumaWeights, PageRegion, Slider, Switch, block
from vidstyle.blocks.pattern import read_tile
from vidstyle.blocks.pixelate import cell_means, cells_of, whole_side
from vidstyle.core.kernels import TIE_LIFT, cached, compiled, interleaved

DARKEST = np.float32(0.1)
"""A darker colour is not raised to full brightness."""


def shipped_alphabets() -> dict[str, Path]:
    """The glyphs that come with vidstyle, by name (tools/tables/alphabet.py)."""
    return {file.stem: file for file in Path(__file__).with_name("alphabets").glob("*.png")}


def read_alphabet(path: Path) -> tuple[np.ndarray]:
    """Glyphs side by side in a PNG, white on black, each 3/5 as wide as it is high.

    Returns:
        One table, float32 0..1: the glyphs side by side, those that cover least first; in a last row the
        tone from which on each is taken, in the column of its number.

    Raises:
        ValueError: it is not a PNG, or too large, or does not hold 2 or more glyphs that differ in tone.
        OSError: it cannot be read.
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
        raise ValueError("has glyphs of one tone only")
    tones = np.zeros((1, columns), np.float32)
    tones[0, 1:count] = ((cover[1:] + cover[:-1]) / 2 - cover[0]) / (cover[-1] - cover[0])
    return (np.vstack([np.hstack(list(glyphs[order])), tones]),)


def _sides(cell: float) -> tuple[int, int]:
    """Height and width of a cell in whole pixels, 5 to 3."""
    width = whole_side(cell)
    return (10 * width + 3) // 6, width


@block("filter", on="channels", radius=lambda cell: max(_sides(cell)) - 1)
def glyphs(
    picture: np.ndarray,
    place: PageRegion,
    weights: LumaWeights,
    alphabet: Annotated[
        Any, Asset("name of an alphabet, or a .png of glyphs side by side", read_alphabet, shipped_alphabets)
    ] = "letters",
    cell: Annotated[float, Slider(3, 64, "width of a glyph, in whole pixels", "px", explore=(5, 12))] = 8,
    invert: Annotated[bool, Switch("on white, with more of a glyph where it is darker")] = False,
) -> np.ndarray:
    """Draw a glyph in each cell of the page: the brighter it is, the more of the cell it covers.

    On black; white glyphs for a gray picture, else in the cell's mean colour at full brightness, unless it is
    nearly black. Glyphs are averaged over each pixel, so that they are smooth at any size.
    """
    (table,), (height, width) = alphabet, _sides(cell)
    rows, columns = cells_of(picture, place, height, width)
    means = np.clip(cell_means(picture, rows, columns), 0, 1)
    if invert:
        means = np.float32(1) - means
    luma = means if picture.ndim == 2 else means @ weights
    count = 5 * table.shape[1] // (3 * (table.shape[0] - 1))
    numbers = np.searchsorted(table[-1, 1:count], luma + TIE_LIFT, side="right")
    lines = np.arange(place.top, place.top + len(rows)) % height
    drawn = _fitted(table.tobytes(), table.shape, height, width)
    channels = means.reshape(*luma.shape, -1)
    colors = channels / np.maximum(channels.max(axis=2, keepdims=True), DARKEST)
    out = np.empty(picture.shape, np.float32)
    _draw(drawn, numbers, colors, (rows, int(columns[-1]) + 1), lines, invert, interleaved(out))
    return out


@compiled
def _draw(glyphs_, numbers, colors, cells, lines, invert, out):  # type: ignore[no-untyped-def]
    """Each pixel's share of its cell's glyph, times the cell's colour."""
    (rows, columns), channels, side = cells, colors.shape[2], glyphs_.shape[2]
    for y in range(out.shape[0]):
        for column in range(columns):
            glyph = glyphs_[numbers[rows[y], column], lines[y]]
            part = out[y, channels * column * side :]
            for channel in range(channels):
                color = colors[rows[y], column, channel]
                for x in range(min(side, part.size // channels)):
                    value = color * glyph[x]
                    part[channels * x + channel] = np.float32(1) - value if invert else value


@cached(maxsize=4)
def _fitted(table: bytes, shape: tuple[int, int], height: int, width: int) -> np.ndarray:
    """The glyphs averaged over the pixels of a cell: glyphs x height x width float32."""
    strip = np.frombuffer(table, np.float32).reshape(shape)[:-1]
    slim = len(strip) * 3 // 5
    drawn = strip.reshape(len(strip), -1, slim).transpose(1, 0, 2).astype(np.float64)
    return (_shares(height, len(strip)) @ drawn @ _shares(width, slim).T).astype(np.float32)


def _shares(pixels: int, parts: int) -> np.ndarray:
    """How much of each pixel each part of a side takes, pixels x parts."""
    edges = np.arange(pixels + 1)[:, None] * parts / pixels - np.arange(parts)
    passed = np.clip(edges, 0, 1)
    return np.diff(passed, axis=0) * pixels / parts
