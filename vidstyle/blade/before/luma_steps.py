"""The steps that change luma before the filters of a bank."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from vidstyle.blade.before.local_mode import local_mode
from vidstyle.blade.before.percentile_curve import KNOT_NAMES, percentile_curve
from vidstyle.block import Block, Margin, Percentiles, ResultRows
from vidstyle.core.sampling import percentiles, sample_plane

LumaStep = tuple[Block, dict[str, Any]]
"""A block of luma, and all its values."""


def luma_steps(curve: np.ndarray | None, mode: np.ndarray | None, amount: float = 1) -> tuple[LumaStep, ...]:
    """Return the steps of a bank's `curve` and `mode`, in order; `amount` is their weight."""
    found: list[LumaStep] = []
    if curve is not None:
        found.append((percentile_curve, _values_of_curve(curve) | {"amount": amount}))
    if mode is not None:
        radius, exponent = mode.tolist()
        values = {"radius": radius, "exponent": exponent, "amount": amount}
        found.append((local_mode, local_mode.arguments_for(values)))
    return tuple(found)


def _values_of_curve(curve: np.ndarray) -> dict[str, Any]:
    """Return the values of a tone curve through four percentiles, or straight between two."""
    straight = len(curve) == 2
    if straight:
        curve = np.column_stack([curve[[0, 0, 1, 1], 0], np.linspace(curve[0, 1], curve[1, 1], 4)])
    names = (f"{prefix}{name}" for prefix in ("", "level_") for name in KNOT_NAMES)
    numbers = dict(zip(names, curve.T.ravel().tolist(), strict=True))
    return percentile_curve.arguments_for(numbers | {"straight": straight})


def prepare(luma: np.ndarray, steps: Sequence[LumaStep]) -> np.ndarray:
    """Return luma, H x W float32, after some steps, with percentiles of a small copy as in a style."""
    for block, values in steps:
        asked = block.percentiles_for(values)
        measured = np.minimum(percentiles(sample_plane(luma), asked), 1) if asked else None
        given: dict[object, Any] = {Percentiles: measured, Margin: (0, 0), ResultRows: np.empty_like(luma)}
        luma = block.function(luma, **values, **{name: given[kind] for name, kind in block.injected.items()})
    return luma
