"""Separation: the amounts of three inks that print a picture."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from vidstyle.block import Color, ResultRows, block
from vidstyle.core.kernels import compiled, interleaved

SWEEP_COUNT = 4
"""How often each ink is adjusted to the two others; a fifth time changes amounts by less than 0.02."""


@block(
    "pixel",
    on="color",
    label="Separate spot inks",
    category="print",
    aliases="riso, screen print, plates, spot colours, colour separation",
)
def separate(
    picture: np.ndarray,
    out: ResultRows,
    first: Annotated[Any, Color("ink of the red channel", label="First ink")] = "#ffe14d",
    second: Annotated[Any, Color("ink of the green channel", label="Second ink")] = "#ff48a0",
    third: Annotated[Any, Color("ink of the blue channel", label="Third ink")] = "#0f5fb0",
) -> np.ndarray:
    """Split the colours into three inks, for printing with spot inks.

    Each channel is the plate of an ink, black where it is full. The amounts, 0..1, have the least squared
    error when the inks lie over each other on white paper, found by coordinate descent. Black and white
    the plates, `shift` them out of register, then print them with `overprint`.
    """
    absorbed = 1 - np.stack([first, second, third]).astype(np.float32)
    rows = np.empty((6, picture.shape[1]), np.float32)
    _separate(interleaved(picture), absorbed, rows[:3], rows[3:], interleaved(out))
    return out


@compiled
def _separate(colors, absorbed, wanted, amounts, out):  # type: ignore[no-untyped-def]
    """Find the amounts of inks, row by row and ink by ink, vectorized.

    Args:
        absorbed: share of red, green and blue that each ink absorbs, 3 x 3.
        wanted, amounts: scratch for a row, three planes each.
    """
    for row in range(out.shape[0]):
        for x in range(wanted.shape[1]):
            i = 3 * x
            wanted[0, x], wanted[1, x], wanted[2, x] = colors[row, i], colors[row, i + 1], colors[row, i + 2]
            amounts[0, x], amounts[1, x] = np.float32(0), np.float32(0)
        for _ in range(SWEEP_COUNT):
            _adjust(wanted, absorbed[2], absorbed[0], absorbed[1], amounts[2], amounts[0], amounts[1])
            _adjust(wanted, absorbed[1], absorbed[0], absorbed[2], amounts[1], amounts[0], amounts[2])
            _adjust(wanted, absorbed[0], absorbed[1], absorbed[2], amounts[0], amounts[1], amounts[2])
        for x in range(wanted.shape[1]):
            for ink in range(3):
                out[row, 3 * x + ink] = np.float32(1) - amounts[ink, x]


@compiled(fastmath=True, noalias=True)
def _adjust(wanted, ink, one, other, amount, one_amount, other_amount):  # type: ignore[no-untyped-def]
    """Find the best amount of an ink in a row, over given amounts of the two others."""
    zero, unit = np.float32(0), np.float32(1)
    for x in range(amount.size):
        a, b = one_amount[x], other_amount[x]
        red = (unit - a * one[0]) * (unit - b * other[0])
        green = (unit - a * one[1]) * (unit - b * other[1])
        blue = (unit - a * one[2]) * (unit - b * other[2])
        i, j, k = red * ink[0], green * ink[1], blue * ink[2]
        products = i * (red - wanted[0, x]) + j * (green - wanted[1, x]) + k * (blue - wanted[2, x])
        squares = np.float32(1e-6) + i * i + j * j + k * k
        amount[x] = min(max(products / squares, zero), unit)
