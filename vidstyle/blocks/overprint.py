"""Overprint: three plates printed over each other in spot inks."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from vidstyle.block import ResultRows, block
from vidstyle.blocks.separate import separate
from vidstyle.core.kernels import compiled, interleaved

_INKS = separate.parameters


@block(
    "pixel",
    on="color",
    label="Print in spot inks",
    category="print",
    aliases="riso, screen print, spot colours, plates, ink, risograph",
)
def overprint(
    picture: np.ndarray,
    out: ResultRows,
    first: Annotated[Any, _INKS["first"].control] = _INKS["first"].default,
    second: Annotated[Any, _INKS["second"].control] = _INKS["second"].default,
    third: Annotated[Any, _INKS["third"].control] = _INKS["third"].default,
) -> np.ndarray:
    """Print three inks over each other on white paper.

    The plates are those that `separate` makes. Inks are transparent: each multiplies the light of those
    below it.
    """
    inks = np.stack([first, second, third]).astype(np.float32)
    _print(interleaved(picture), 1 - inks, interleaved(out))
    return out


@compiled(fastmath=True)
def _print(plates, absorbed, out):  # type: ignore[no-untyped-def]
    one = np.float32(1)
    for row in range(out.shape[0]):
        for x in range(out.shape[1] // 3):
            i, j, k = 3 * x, 3 * x + 1, 3 * x + 2
            a, b, c = one - plates[row, i], one - plates[row, j], one - plates[row, k]
            for channel in range(3):
                light = (one - a * absorbed[0, channel]) * (one - b * absorbed[1, channel])
                out[row, i + channel] = light * (one - c * absorbed[2, channel])
