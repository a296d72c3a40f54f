"""Blend: lays a saved picture over the current one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Choice, Limits, ResultRows, SavedRef, Slider, block
from vidstyle.core.kernels import Compiled, compiled, gray_or_interleaved, interleaved, repeat_row

ZERO, HALF, ONE, TWO = np.float32(0), np.float32(0.5), np.float32(1), np.float32(2)
LEAST = np.float32(1 / 255)
"""The least divisor."""
NO_MASK = np.empty((0, 0), np.float32)

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


@block("pixel", on="channels")
def blend(
    picture: np.ndarray,
    out: ResultRows,
    limits: Limits,
    other: Annotated[Any, SavedRef("picture blended over the current one")] = "source",
    mode: Annotated[str, Choice(tuple(MODES), "blend mode", explore=("multiply", "overlay"))] = "normal",
    opacity: Annotated[float, Slider(0, 1, "0 for no effect", explore=(0.3, 1))] = 0.5,
    mask: Annotated[
        Any, SavedRef("picture whose luma multiplies the opacity", on="luma", optional=True)
    ] = "",
) -> np.ndarray:
    """Blend a saved picture over the current one; over a gray one, its luma."""
    weights = NO_MASK if mask is None else np.ascontiguousarray(mask)
    ends = np.float32(limits[0]), np.float32(limits[1])
    pictures = interleaved(picture), gray_or_interleaved(other)
    line = np.empty(pictures[0].shape[1], np.float32)
    _blend(*pictures, weights, MODES[mode], np.float32(opacity), ends, line, interleaved(out))
    return out


@compiled
def _blend(below, above, mask, mode, opacity, ends, line, out):  # type: ignore[no-untyped-def]
    """Row by row; the mask has a number for each pixel, or none.

    Args:
        above: the upper picture; its luma, if it alone is gray.
        line: scratch, a row.
    """
    for row in range(out.shape[0]):
        upper = above[row]
        if upper.size < line.size:
            repeat_row(upper, line)
            upper = line
        if mask.size == 0:
            for x in range(out.shape[1]):
                out[row, x] = _mix(below[row, x], upper[x], mode, opacity, ends)
        elif mask.shape[1] == out.shape[1]:
            for x in range(out.shape[1]):
                out[row, x] = _mix(below[row, x], upper[x], mode, opacity * mask[row, x], ends)
        else:
            for x in range(mask.shape[1]):
                opacity_here = opacity * mask[row, x]
                i, j, k = 3 * x, 3 * x + 1, 3 * x + 2
                out[row, i] = _mix(below[row, i], upper[i], mode, opacity_here, ends)
                out[row, j] = _mix(below[row, j], upper[j], mode, opacity_here, ends)
                out[row, k] = _mix(below[row, k], upper[k], mode, opacity_here, ends)


@compiled
def _mix(below, above, mode, opacity, ends):  # type: ignore[no-untyped-def]
    mixed = mode(below, above)
    part = below + opacity * (mixed - below)
    return min(max(mixed if opacity == ONE else part, ends[0]), ends[1])
