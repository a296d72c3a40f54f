"""Blend: lays a saved picture over the current one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Choice, SavedRef, Slider, block
from vidstyle.core.kernels import Compiled, compiled, interleaved

ZERO, HALF, ONE, TWO = np.float32(0), np.float32(0.5), np.float32(1), np.float32(2)
LEAST = np.float32(1 / 255)
"""The least divisor."""

MODES: dict[str, Compiled[..., Any]] = {}
"""The blend modes: formulas of one number of each picture."""


def _mode(formula: Callable[..., Any]) -> Compiled[..., Any]:
    """Declare a mode by its name."""
    return MODES.setdefault(formula.__name__.strip("_"), compiled(formula))


@_mode
def _normal(below, above):  # type: ignore[no-untyped-def]
    return above


@_mode
def _multiply(below, above):  # type: ignore[no-untyped-def]
    return below * above


@_mode
def _screen(below, above):  # type: ignore[no-untyped-def]
    return below + above - below * above


@_mode
def _overlay(below, above):  # type: ignore[no-untyped-def]
    return TWO * above * below if below < HALF else ONE - TWO * (ONE - above) * (ONE - below)


@_mode
def _hard_light(below, above):  # type: ignore[no-untyped-def]
    return TWO * below * above if above < HALF else ONE - TWO * (ONE - below) * (ONE - above)


@_mode
def _soft_light(below, above):  # type: ignore[no-untyped-def]
    return below * (TWO * above + below * (ONE - TWO * above))


@_mode
def _darken(below, above):  # type: ignore[no-untyped-def]
    return min(below, above)


@_mode
def _lighten(below, above):  # type: ignore[no-untyped-def]
    return max(below, above)


@_mode
def _add(below, above):  # type: ignore[no-untyped-def]
    return min(below + above, ONE)


@_mode
def _subtract(below, above):  # type: ignore[no-untyped-def]
    return max(below - above, ZERO)


@_mode
def _difference(below, above):  # type: ignore[no-untyped-def]
    return abs(below - above)


@_mode
def _grain_extract(below, above):  # type: ignore[no-untyped-def]
    return min(max(below - above + HALF, ZERO), ONE)


@_mode
def _grain_merge(below, above):  # type: ignore[no-untyped-def]
    return min(max(below + above - HALF, ZERO), ONE)


@_mode
def _divide(below, above):  # type: ignore[no-untyped-def]
    return min(max(below / max(above, LEAST), ZERO), ONE)


@_mode
def _dodge(below, above):  # type: ignore[no-untyped-def]
    return min(max(below / max(ONE - above, LEAST), ZERO), ONE)


@_mode
def _burn(below, above):  # type: ignore[no-untyped-def]
    return ONE - min(max((ONE - below) / max(above, LEAST), ZERO), ONE)


@block("pixel", on="channels", overshoots=True)
def blend(
    picture: np.ndarray,
    other: Annotated[Any, SavedRef("picture blended over the current one")] = "source",
    mode: Annotated[str, Choice(tuple(MODES), "blend mode", explore=("multiply", "overlay"))] = "normal",
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
    _blend(*pictures, weights, MODES[mode], np.float32(opacity), line, interleaved(out))
    return out


@compiled
def _blend(below, above, mask, mode, opacity, line, out):  # type: ignore[no-untyped-def]
    """Row by row.

    Args:
        mask: a number for each pixel, or none.
        mode: the formula, one of `MODES`.
        line: scratch, the weight of each number of a row.
    """
    for row in range(out.shape[0]):
        if mask.size == 0:
            for x in range(out.shape[1]):
                mixed = mode(below[row, x], above[row, x])
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
                mixed = mode(below[row, x], above[row, x])
                out[row, x] = below[row, x] + line[x] * (mixed - below[row, x])
