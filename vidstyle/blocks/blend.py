"""Blend: lays a saved picture over the current one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

import numpy as np

from vidstyle.block import Choice, Limits, ResultRows, SavedRef, Slider, block
from vidstyle.core.kernels import Compiled, compiled, gray_or_interleaved, interleaved, repeat_row

BLACK_LEVEL, MIDDLE_LEVEL, WHITE_LEVEL = np.float32(0), np.float32(0.5), np.float32(1)
DOUBLE_FACTOR = np.float32(2)
MIN_DIVISOR = np.float32(1 / 255)
"""Smallest divisor of `divide`, `dodge` and `burn`: one level of 255."""
NO_MASK_WEIGHTS = np.empty((0, 0), np.float32)

MODE_FORMULAS: dict[str, Compiled[..., Any]] = {}
"""The formula of each blend mode, from one number of each picture."""


def _mode(formula: Callable[..., Any]) -> Compiled[..., Any]:
    """Declare a formula as the mode of the same name."""
    return MODE_FORMULAS.setdefault(formula.__name__.strip("_"), compiled(formula))


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
    return (
        DOUBLE_FACTOR * above * below
        if below < MIDDLE_LEVEL
        else WHITE_LEVEL - DOUBLE_FACTOR * (WHITE_LEVEL - above) * (WHITE_LEVEL - below)
    )


@_mode
def _hard_light(below, above):  # type: ignore[no-untyped-def]
    return (
        DOUBLE_FACTOR * below * above
        if above < MIDDLE_LEVEL
        else WHITE_LEVEL - DOUBLE_FACTOR * (WHITE_LEVEL - below) * (WHITE_LEVEL - above)
    )


@_mode
def _soft_light(below, above):  # type: ignore[no-untyped-def]
    return below * (DOUBLE_FACTOR * above + below * (WHITE_LEVEL - DOUBLE_FACTOR * above))


@_mode
def _darken(below, above):  # type: ignore[no-untyped-def]
    return min(below, above)


@_mode
def _lighten(below, above):  # type: ignore[no-untyped-def]
    return max(below, above)


@_mode
def _add(below, above):  # type: ignore[no-untyped-def]
    return min(below + above, WHITE_LEVEL)


@_mode
def _subtract(below, above):  # type: ignore[no-untyped-def]
    return max(below - above, BLACK_LEVEL)


@_mode
def _difference(below, above):  # type: ignore[no-untyped-def]
    return abs(below - above)


@_mode
def _grain_extract(below, above):  # type: ignore[no-untyped-def]
    return min(max(below - above + MIDDLE_LEVEL, BLACK_LEVEL), WHITE_LEVEL)


@_mode
def _grain_merge(below, above):  # type: ignore[no-untyped-def]
    # Highlights of HDR, above white, stay there.
    return min(max(below + above - MIDDLE_LEVEL, BLACK_LEVEL), max(below, WHITE_LEVEL))


@_mode
def _divide(below, above):  # type: ignore[no-untyped-def]
    return min(max(below / max(above, MIN_DIVISOR), BLACK_LEVEL), WHITE_LEVEL)


@_mode
def _dodge(below, above):  # type: ignore[no-untyped-def]
    return min(max(below / max(WHITE_LEVEL - above, MIN_DIVISOR), BLACK_LEVEL), WHITE_LEVEL)


@_mode
def _burn(below, above):  # type: ignore[no-untyped-def]
    return WHITE_LEVEL - min(max((WHITE_LEVEL - below) / max(above, MIN_DIVISOR), BLACK_LEVEL), WHITE_LEVEL)


@block(
    "pixel",
    on="channels",
    label="Blend pictures",
    category="combine",
    aliases=(
        "mix, overlay, multiply, screen, merge, layer, double exposure, opacity, glow, bloom, "
        "mask, dreamy, shine, light leak"
    ),
)
def blend(
    picture: np.ndarray,
    out: ResultRows,
    limits: Limits,
    other: Annotated[Any, SavedRef("picture to lay over this one", label="Picture on top")] = "source",
    mode: Annotated[
        str,
        Choice(
            tuple(MODE_FORMULAS),
            "how they mix: normal covers, multiply darkens, screen lightens",
            explore=("multiply", "overlay"),
            label="Blend mode",
        ),
    ] = "normal",
    opacity: Annotated[
        float,
        Slider(
            0, 1, "how much the picture on top shows; 0 for no effect", explore=(0.3, 1), label="Blend amount"
        ),
    ] = 0.5,
    mask: Annotated[
        Any,
        SavedRef(
            "picture on top shows where this one is bright; empty for everywhere",
            on="luma",
            optional=True,
            label="Blend mask",
        ),
    ] = "",
) -> np.ndarray:
    """Lay a saved picture over the present one, as layers of an image editor do.

    Only the luma of a colour picture is blended if the current one is gray.
    """
    weights = NO_MASK_WEIGHTS if mask is None else np.ascontiguousarray(mask)
    ends = np.float32(limits[0]), np.float32(limits[1])
    pictures = interleaved(picture), gray_or_interleaved(other)
    line = np.empty(pictures[0].shape[1], np.float32)
    _blend(*pictures, weights, MODE_FORMULAS[mode], np.float32(opacity), ends, line, interleaved(out))
    return out


@compiled
def _blend(below, above, mask, mode, opacity, ends, line, out):  # type: ignore[no-untyped-def]
    """Blend row by row; the mask is H x W, or empty.

    Args:
        above: the upper picture; its luma if only this one is gray.
        line: scratch, one row.
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
    return min(max(mixed if opacity == WHITE_LEVEL else part, ends[0]), ends[1])
