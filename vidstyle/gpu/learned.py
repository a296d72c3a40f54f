"""What the shaders of learned blocks are given."""

from __future__ import annotations

from typing import Any

from vidstyle.blade.features import window_reach, window_weights
from vidstyle.blade.run import BankRun

MOST_TAPS = 16
"""Weights of one half of the window that the shader takes."""
MOST_PARTS = 8


def choice_values(run: BankRun) -> dict[str, Any]:
    """The values of `chosen_filter`."""
    reach = window_reach(run.window)
    half = [float(weight) for weight in window_weights(run.window)[:reach]]
    orientations, strengths, coherences, *ranges = (float(number) for number in run.bank.bins.numbers)
    return {
        "reach": reach,
        "window": half + [0.0] * (MOST_TAPS - len(half)),
        "bins": (orientations, strengths, coherences),
        "start": (ranges[0], ranges[2]),
        "density": (ranges[1], ranges[3]),
    }


def filter_values(run: BankRun) -> dict[str, Any]:
    """The values of `filtered`."""
    padding = [0.0] * (MOST_PARTS - len(run.weights))
    return {
        # Weights times twenty and more would show the rounding of half floats.
        "bank": run.bank.packed if run.is_wide else run.bank.packed_in_half,
        "size": run.bank.size,
        "part_weights": [float(weight) for weight in run.weights] + padding,
        "part_sums": [*run.bank.sums, *padding],
        "identity": float(run.identity),
    }
