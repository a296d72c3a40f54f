"""Ramps between two values."""

from __future__ import annotations

import numpy as np


def ramp(value: np.ndarray | float, ends: tuple[float, float]) -> np.ndarray:
    """Return a linear ramp from 0 at the first of `ends` to 1 at the second one, float32.

    >>> ramp(3.5, (3, 5)).item(), ramp(6, (3, 5)).item(), ramp(6, (5, 3)).item()
    (0.25, 1.0, 0.0)
    """
    none, whole = map(np.float32, ends)
    return np.asarray(np.clip((value - none) / (whole - none), 0, 1), np.float32)
