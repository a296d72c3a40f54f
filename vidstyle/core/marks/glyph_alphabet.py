"""Alphabets of glyphs: their pictures, and the coverage of their zones."""

from __future__ import annotations

import numpy as np

from vidstyle.core.kernels import cached

ZONE_ROWS, ZONE_COLUMNS = 3, 2
ZONE_COUNT = ZONE_ROWS * ZONE_COLUMNS
"""Zones of a cell, which are compared with the zones of glyphs."""


class Alphabet(tuple[np.ndarray]):
    """A table, float32 0..1; compared by identity.

    The upper rows hold the glyphs side by side, sorted by increasing coverage. The last six rows have one
    column for each glyph: the coverage of its six zones, relative to the mean coverage of the densest glyph.
    """

    __eq__, __hash__ = object.__eq__, object.__hash__


def alphabet_from_tile(tile: np.ndarray) -> Alphabet:
    """Return an alphabet from glyphs side by side, white on black, each 3/5 as wide as it is high.

    Args:
        tile: H x W, 0..1.

    Raises:
        ValueError: there are fewer than two glyphs, or all have the same coverage.
    """
    height, columns = tile.shape
    width = height * 3 // 5
    count = columns // max(width, 1)
    if height % 5 or columns % max(width, 1) or count < 2:
        raise ValueError("needs 2 or more glyphs side by side, each 3/5 as wide as it is high")
    glyphs = tile.reshape(height, count, width).transpose(1, 0, 2)
    cover = glyphs.mean(axis=(1, 2))
    order = np.argsort(cover, kind="stable")
    if cover[order[-1]] <= cover[order[0]]:
        raise ValueError("has glyphs of only one tone")
    sorted_ = glyphs[order].astype(np.float64)
    zones = _shares(ZONE_ROWS, height) @ sorted_ @ _shares(ZONE_COLUMNS, width).T
    shapes = np.zeros((ZONE_COUNT, columns), np.float32)
    shapes[:, :count] = zones.reshape(count, ZONE_COUNT).T / cover[order[-1]]
    return Alphabet([np.vstack([np.hstack(list(glyphs[order])), shapes])])


@cached(maxsize=4)
def shapes_of(alphabet: Alphabet) -> np.ndarray:
    """Return the coverage of the zones of each glyph, glyphs x zones."""
    (table,) = alphabet
    count = 5 * table.shape[1] // (3 * (table.shape[0] - ZONE_COUNT))
    return np.ascontiguousarray(table[-ZONE_COUNT:, :count].T)


@cached(maxsize=4)
def fit_to_cell(alphabet: Alphabet, height: int, width: int) -> np.ndarray:
    """Average the glyphs over the pixels of a cell: float32, the rows of all glyphs, as wide as a cell."""
    strip = alphabet[0][:-ZONE_COUNT]
    slim = len(strip) * 3 // 5
    drawn = strip.reshape(len(strip), -1, slim).transpose(1, 0, 2).astype(np.float64)
    return (
        (_shares(height, len(strip)) @ drawn @ _shares(width, slim).T).astype(np.float32).reshape(-1, width)
    )


def _shares(pixels: int, parts: int) -> np.ndarray:
    """Return the share of each pixel that each part of a side covers, pixels x parts."""
    edges = np.arange(pixels + 1)[:, None] * parts / pixels - np.arange(parts)
    passed = np.clip(edges, 0, 1)
    return np.diff(passed, axis=0) * pixels / parts
