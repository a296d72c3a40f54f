"""Black bars above and below a picture, or beside it, which no panel shows."""

from __future__ import annotations

import numpy as np

_DARK = 30
"""No pixel of a bar is lighter, of 255,"""
_EVEN = 12
"""nor do two differ by more."""
_LEAST, _MOST = 0.02, 0.35
"""The part of a side that a bar takes."""


def between_bars(color: np.ndarray) -> tuple[slice, slice]:
    """The rows and columns of a picture, H x W x 3 uint8, between bars of equal width; all without such."""
    luma = color.max(axis=2)
    return _between(luma), _between(luma.T)


def _between(luma: np.ndarray) -> slice:
    brightest, darkest = luma.max(axis=1), luma.min(axis=1)
    shown = np.flatnonzero((brightest > _DARK) | (brightest - darkest > _EVEN))
    count = len(luma)
    bar = min(int(shown[0]), count - 1 - int(shown[-1])) if len(shown) else 0
    # A line more, into which bar and picture were mixed.
    return slice(bar + 1, count - bar - 1) if _LEAST * count <= bar <= _MOST * count else slice(0, count)
