"""Blend: lays a saved picture over the current one."""

from __future__ import annotations

from typing import Annotated, Any

import numpy as np

from vidstyle.block import Choice, SavedRef, Slider, block
from vidstyle.core.kernels import compiled, interleaved

MODES = (
    "normal", "multiply", "screen", "overlay", "hard_light", "soft_light", "darken", "lighten", "add",
    "subtract", "difference", "grain_extract", "grain_merge", "divide", "dodge", "burn",
)  # fmt: skip
"""The blend modes; `_mixed` has their formulas in this order."""


@block("pixel", on="channels", overshoots=True)
def blend(
    picture: np.ndarray,
    other: Annotated[Any, SavedRef("picture blended over the current one")] = "source",
    mode: Annotated[str, Choice(MODES, "blend mode", explore=("multiply", "overlay"))] = "normal",
    opacity: Annotated[float, Slider(0, 1, "0 for no effect", explore=(0.3, 1))] = 0.5,
    mask: Annotated[
        Any, SavedRef("picture whose luma multiplies the opacity", on="luma", optional=True)
    ] = "",
) -> np.ndarray:
    """Blend a saved picture over the current one; over a gray one, its luma."""
    out = np.empty(picture.shape, np.float32)
    weights = np.empty((0, 0), np.float32) if mask is None else np.ascontiguousarray(mask)
    line = np.empty(out[0].size, np.float32)
    pictures = interleaved(picture), interleaved(other)
    _blend(*pictures, weights, (0,) * (1 + MODES.index(mode)), np.float32(opacity), line, interleaved(out))
    return out


@compiled
def _mixed(mode, below, above):  # type: ignore[no-untyped-def]
    """One number of both pictures in the blend mode."""
    zero, half, one, two, least = (
        np.float32(0),
        np.float32(0.5),
        np.float32(1),
        np.float32(2),
        np.float32(1 / 255),
    )
    if mode == 1:
        return below * above
    if mode == 2:
        return below + above - below * above
    if mode == 3:
        return two * above * below if below < half else one - two * (one - above) * (one - below)
    if mode == 4:
        return two * below * above if above < half else one - two * (one - below) * (one - above)
    if mode == 5:
        return below * (two * above + below * (one - two * above))
    if mode == 6:
        return min(below, above)
    if mode == 7:
        return max(below, above)
    if mode == 8:
        return min(below + above, one)
    if mode == 9:
        return max(below - above, zero)
    if mode == 10:
        return abs(below - above)
    if mode == 11:
        return min(max(below - above + half, zero), one)
    if mode == 12:
        return min(max(below + above - half, zero), one)
    if mode == 13:
        return min(max(below / max(above, least), zero), one)
    if mode == 14:
        return min(max(below / max(one - above, least), zero), one)
    if mode == 15:
        return one - min(max((one - below) / max(above, least), zero), one)
    return above


@compiled
def _blend(below, above, mask, mode, opacity, line, out):  # type: ignore[no-untyped-def]
    """Row by row.

    Args:
        mask: a number for each pixel, or none.
        mode: a tuple with one number for the mode and each before it: the compiler knows its length, and so
            makes vectors of this mode alone.
        line: scratch, the weight of each number of a row.
    """
    for row in range(out.shape[0]):
        if mask.size == 0:
            for x in range(out.shape[1]):
                mixed = _mixed(len(mode) - 1, below[row, x], above[row, x])
                part = below[row, x] + opacity * (mixed - below[row, x])
                out[row, x] = mixed if opacity == np.float32(1) else part
        else:
            if mask.shape[1] == line.size:
                for x in range(line.size):
                    line[x] = opacity * mask[row, x]
            else:
                for x in range(mask.shape[1]):
                    weight = opacity * mask[row, x]
                    line[3 * x], line[3 * x + 1], line[3 * x + 2] = weight, weight, weight
            for x in range(line.size):
                mixed = _mixed(len(mode) - 1, below[row, x], above[row, x])
                out[row, x] = below[row, x] + line[x] * (mixed - below[row, x])
