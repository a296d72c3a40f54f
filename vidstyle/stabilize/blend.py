"""Blends a plane of a frame with the plane of the previous frame, warped along the motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from vidstyle.stabilize.blend_codes import FULL_WEIGHT, LIMIT_STEPS, result_code_rows, source_code_rows
from vidstyle.stabilize.blend_floats import result_float_rows, source_float_rows
from vidstyle.stabilize.segment import SEGMENT_SIZE
from vidstyle.stabilize.warp import LINE_COUNT, Moves, whole_segments

Rows = Callable[[int, int], None]
"""Computes the rows from the first number up to, but not including, the second."""

_FULL_WEIGHT_FACTOR = 257
"""The weight 1 in the form that kernels multiply by stored weights."""
_NO_GUIDE_WEIGHTS = np.zeros((1, 1), np.uint8)


def source_rows(
    plane: np.ndarray,
    scale: tuple[float, float],
    before: np.ndarray,
    moves: Moves,
    weight: float,
    limit: float,
    guide: np.ndarray | None,
    step: tuple[int, int],
    out: np.ndarray,
    weights: np.ndarray | None,
) -> Rows:
    """Warp the previous plane of the source and blend it into this one.

    Change is the root mean square difference over 3 x 3 samples. With r = (change / limit)^2, the weight of
    the previous plane is weight * guide / (1 + r^2).

    Args:
        plane: H x W; codes if `out` has 16 bits, otherwise of any type.
        scale: gain and offset from its codes to units of the result.
        before: `out` for the previous frame, float32 or uint16, contiguous.
        moves: displacement of the plane; see `moves_of`.
        weight: weight of the previous plane, 0..1.
        limit: change that halves the weight, in units of the result.
        guide: weights of the luma plane, whose rows must be computed before; None for 1.
        step: luma pixels per sample of this plane, across and down.
        out: written, the new plane.
        weights: written, 1 / (1 + r^2), H x W uint8, with 1 as `FULL_WEIGHT`; None if not needed.
    """
    guide, samples, width = _NO_GUIDE_WEIGHTS if guide is None else guide, before.reshape(-1), plane.shape[1]
    floats, padded = out.dtype == np.float32, whole_segments(width)
    if not floats and scale[0] % 1:  # full range of more than 8 bits
        plane, scale = (plane * np.float32(scale[0]) + np.float32(scale[1] + 0.5)).astype(np.uint16), (1, 0)
    numbers = _float_numbers(scale, weight, limit) if floats else _code_numbers(scale, weight, limit)

    def run(top: int, bottom: int) -> None:
        kept = np.empty((1, width), np.uint8) if weights is None else weights
        same = plane, before, samples, moves, guide, step
        lines, changes = np.empty((LINE_COUNT, padded), out.dtype), np.empty((3, width + 2), out.dtype)
        squares = changes, np.empty(width + 2, out.dtype)
        beside = np.empty(4 * SEGMENT_SIZE, out.dtype)
        if floats:
            scratch = lines, squares, (np.empty(width, out.dtype), np.empty(width, out.dtype)), beside
            source_float_rows(*same, numbers, (top, bottom), scratch, kept, out)
        else:
            others = np.empty((3, width), out.dtype)
            own = np.empty(width, np.uint8), np.full(width, FULL_WEIGHT, np.uint8)
            source_code_rows(*same, numbers, (top, bottom), (lines, squares, others, own, beside), kept, out)

    return run


def result_rows(
    plane: np.ndarray,
    gain: float,
    before: np.ndarray,
    moves: Moves,
    segment_weights: np.ndarray,
    weight: float,
    guide: np.ndarray,
    step: tuple[int, int],
    out: np.ndarray,
    codes: np.ndarray,
) -> Rows:
    """Warp the previous plane of the result and blend it into this one, with the weights of the source.

    Args:
        plane, before, moves, weight, guide, step, out: see `source_rows`.
        gain: factor from its codes to units of `out`.
        segment_weights: additional weights of segments, h x w x 1.
        codes: written, the new plane in the codes of `plane`.
    """
    samples, width, parts = before.reshape(-1), plane.shape[1], segment_weights[..., 0]
    padded = whole_segments(width)
    stored = (parts * np.float32(FULL_WEIGHT)).astype(np.uint8)
    numbers = np.array([gain, gain // 2, math.log2(gain), weight * _FULL_WEIGHT_FACTOR], np.uint16)

    def run(top: int, bottom: int) -> None:
        same = plane, before, samples, moves
        lines, beside = np.empty((LINE_COUNT, padded), out.dtype), np.empty(4 * SEGMENT_SIZE, out.dtype)
        factors = np.empty(width, out.dtype)
        if out.dtype == np.float32:
            shares = parts * np.float32(weight)
            result_float_rows(*same, shares, guide, step, (top, bottom), (lines, factors, beside), out)
            codes[top:bottom] = out[top:bottom]
        else:
            scratch = lines, factors, np.empty(width, np.uint8), beside
            result_code_rows(*same, stored, guide, step, numbers, (top, bottom), scratch, out, codes)

    return run


def _float_numbers(scale: tuple[float, float], weight: float, limit: float) -> tuple[Any, ...]:
    """Return the argument `numbers` of `source_float_rows`."""
    return tuple(np.float32(number) for number in (*scale, weight, 1 / (9 * limit**2)))


def _code_numbers(scale: tuple[float, float], weight: float, limit: float) -> tuple[Any, ...]:
    """Return the argument `numbers` of `source_code_rows`."""
    shift = max(0, math.ceil(math.log2(min(limit, 65535) / LIMIT_STEPS)))
    numbers = [scale[0], -scale[1], (1 << shift) >> 1, shift, weight * _FULL_WEIGHT_FACTOR]
    return np.array(numbers, np.uint16), np.float32((1 << shift) ** 2 / (9 * limit**2))
