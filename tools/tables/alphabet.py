"""Draw the glyphs that ship with `glyphs`, side by side: `python -m tools.tables.alphabet`."""

from __future__ import annotations

import math

import cv2
import numpy as np

from vidstyle.blocks.glyphs import shipped_alphabets

GLYPH_HEIGHT_PX, GLYPH_WIDTH_PX = 40, 24
HEIGHT_UNITS = 10
"""Height of a glyph in the units of `GLYPHS`; it is 6 units wide."""
SUPERSAMPLING_FACTOR = 8
STROKE_WIDTH = 1.15
"""Stroke width in units; dots are slightly wider."""
STRETCH_RATIO, STRETCH_CENTER_HEIGHT = 1.22, 4.95
"""Glyphs are stretched vertically about this height to fill the cell, without dark stripes between rows."""

Points = list[tuple[float, float]]


def ring(x: float, y: float, across: float, down: float, first: int = 0, last: int = 360) -> Points:
    """Return an arc of an ellipse between two angles in degrees: 0 is right, 90 is down."""
    turns = [math.radians(angle) for angle in range(first, last + 1, 6)]
    return [(x + across * math.cos(turn), y + down * math.sin(turn)) for turn in turns]


def letter_s(top: float, bottom: float) -> Points:
    """Return an S between two heights."""
    half = (bottom - top) / 4
    upper, lower = (ring(3, top + part * half, 1.75, half) for part in (1, 3))
    return [*upper[55:14:-1], *lower[45:], *lower[:27]]


GLYPHS: dict[str, list[Points]] = {
    " ": [],
    ".": [[(3, 7.7)]],
    "'": [[(3, 1.4), (3, 3.4)]],
    ",": [[(3.1, 7.3), (2.5, 8.9)]],
    "-": [[(1, 5), (5, 5)]],
    "_": [[(0.4, 8.2), (5.6, 8.2)]],
    '"': [[(2, 1.4), (2, 3.4)], [(4, 1.4), (4, 3.4)]],
    "^": [[(1.3, 3.6), (3, 1.4), (4.7, 3.6)]],
    "/": [[(5.2, 1), (0.8, 8.9)]],
    "\\": [[(0.8, 1), (5.2, 8.9)]],
    "|": [[(3, 0.9), (3, 9)]],
    "(": [ring(5, 4.95, 3, 4.1, 132, 228)],
    ")": [ring(1, 4.95, 3, 4.1, 312, 408)],
    "<": [[(4.9, 2.5), (1.2, 4.95), (4.9, 7.4)]],
    ">": [[(1.1, 2.5), (4.8, 4.95), (1.1, 7.4)]],
    "=": [[(1, 3.9), (5, 3.9)], [(1, 6.1), (5, 6.1)]],
    "L": [[(1.4, 1.6), (1.4, 8.1), (5, 8.1)]],
    "J": [[(4.4, 1.6), (4.4, 6.4), *ring(2.8, 6.4, 1.6, 1.75, 0, 168)]],
    "T": [[(0.7, 1.6), (5.3, 1.6)], [(3, 1.6), (3, 8.1)]],
    "V": [[(0.7, 1.6), (3, 8.1), (5.3, 1.6)]],
    "A": [[(0.7, 8.1), (3, 1.6), (5.3, 8.1)], [(1.5, 6), (4.5, 6)]],
    "7": [[(0.9, 1.6), (5.1, 1.6), (2.4, 8.1)]],
    "o": [ring(3, 6, 1.9, 2.1)],
    "H": [[(1.1, 1.6), (1.1, 8.1)], [(4.9, 1.6), (4.9, 8.1)], [(1.1, 4.8), (4.9, 4.8)]],
    "X": [[(0.8, 1.6), (5.2, 8.1)], [(5.2, 1.6), (0.8, 8.1)]],
    "Z": [[(0.9, 1.6), (5.1, 1.6), (0.9, 8.1), (5.1, 8.1)]],
    "N": [[(1.1, 8.1), (1.1, 1.6), (4.9, 8.1), (4.9, 1.6)]],
    "M": [[(0.8, 8.1), (1, 1.6), (3, 5.6), (5, 1.6), (5.2, 8.1)]],
    ";": [[(3.1, 4.2)], [(3.2, 7.4), (2.6, 9)]],
    "!": [[(3, 1.6), (3, 5.4)], [(3, 7.8)]],
    ":": [[(3, 3.9)], [(3, 7.3)]],
    "+": [[(1, 5), (5, 5)], [(3, 3), (3, 7)]],
    "c": [ring(3.2, 5.9, 1.9, 2.1, 45, 315)],
    "x": [[(1, 3.8), (5, 8)], [(5, 3.8), (1, 8)]],
    "s": [letter_s(3.6, 8.1)],
    "O": [ring(3, 4.9, 2.05, 2.9)],
    "S": [letter_s(1.6, 8.2)],
    "E": [[(5, 1.6), (1.1, 1.6), (1.1, 8.1), (5, 8.1)], [(1.1, 4.8), (4.5, 4.8)]],
    "8": [ring(3, 3.2, 1.75, 1.7), ring(3, 6.5, 2.05, 1.75)],
    "W": [[(0.6, 1.6), (1.7, 8.1), (3, 3), (4.3, 8.1), (5.4, 1.6)]],
    "#": [[(2.1, 1), (1.6, 8.8)], [(4.4, 1), (3.9, 8.8)], [(0.3, 3.4), (5.8, 3.4)],
          [(0.2, 6.4), (5.7, 6.4)]],
    "@": [[*ring(3.1, 4.9, 2.4, 3.7, 60, 360), (5.5, 6.6), (4.2, 6.4)], ring(3.2, 5, 1, 1.5)],
}  # fmt: skip


def draw_glyph(strokes: list[Points]) -> np.ndarray:
    """Return a glyph, white on black, `GLYPH_HEIGHT_PX` x `GLYPH_WIDTH_PX` uint8."""
    large = np.zeros(
        (GLYPH_HEIGHT_PX * SUPERSAMPLING_FACTOR, GLYPH_WIDTH_PX * SUPERSAMPLING_FACTOR), np.uint8
    )
    scale = GLYPH_HEIGHT_PX * SUPERSAMPLING_FACTOR / HEIGHT_UNITS
    for stroke in strokes:
        points = np.array(stroke) * (1, STRETCH_RATIO) + (
            0,
            HEIGHT_UNITS / 2 - STRETCH_RATIO * STRETCH_CENTER_HEIGHT,
        )
        places = (points * scale * 16).round().astype(np.int32)
        if len(stroke) == 1:
            cv2.circle(large, places[0], round(0.65 * STROKE_WIDTH * scale * 16), 255, -1, cv2.LINE_AA, 4)
        cv2.polylines(large, [places], False, 255, round(STROKE_WIDTH * scale), cv2.LINE_AA, 4)
    return cv2.resize(large, (GLYPH_WIDTH_PX, GLYPH_HEIGHT_PX), interpolation=cv2.INTER_AREA)


if __name__ == "__main__":
    cv2.imwrite(
        str(shipped_alphabets()["letters"]), np.hstack([draw_glyph(each) for each in GLYPHS.values()])
    )
