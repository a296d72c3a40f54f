"""Finds cuts: frames that begin a new scene."""

from __future__ import annotations

import numpy as np

HISTOGRAM_CHANGE = 0.35
"""The share of pixels that must have changed their tone. A pan moves few, a cut moves most."""
PICTURE_CHANGE = 0.06
"""The mean change of a pixel, 0..1, that a cut has at least; a fade's histogram moves with less."""

_TONES = 24


class CutDetector:
    """Says for each frame whether it begins a scene; the first one does."""

    def __init__(self) -> None:
        self._luma: np.ndarray | None = None
        self._histogram = np.zeros(_TONES)

    def is_cut(self, luma: np.ndarray) -> bool:
        """Whether the next frame, given as a small H x W float32 copy of its luma, begins a scene."""
        histogram = np.histogram(luma, _TONES, (0, 1))[0] / luma.size
        # A copy: it may be a view of a picture whose owner will draw the next one into it.
        before, self._luma = self._luma, luma.copy()
        change, self._histogram = np.abs(histogram - self._histogram).sum() / 2, histogram
        if before is None or before.shape != luma.shape:
            return True
        return bool(change > HISTOGRAM_CHANGE and np.abs(luma - before).mean() > PICTURE_CHANGE)
