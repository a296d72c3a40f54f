"""Keeps the rate by working on smaller pictures while the style takes too long."""

from __future__ import annotations

from collections import deque
from statistics import median

SCALES = (1.0, 0.75, 0.5, 0.375, 0.25)
"""Working sizes, as shares of the picture's width and height."""
FULL, ROOMY = 0.95, 0.65
"""Shares of the time between two frames: above the first a size is too large, below the second it fits."""
LOOK, PATIENCE, MOST_PATIENCE = 0.5, 2.0, 60.0
"""Seconds to look before going down; before going up; and that at most, after tries that failed."""
LEAST_FRAMES, MOST_FRAMES = 3, 30
"""How many frames are looked at."""


class Budget:
    """Chooses the working size from how long frames take.

    Attributes:
        scale: of SCALES.
    """

    def __init__(self, seconds: float, scales: tuple[float, ...] = SCALES) -> None:
        """`seconds`: between two frames, all of which the style may take."""
        self._seconds, self._scales = seconds, scales
        self._place = 0
        self._patience = PATIENCE
        self._since = self._rose = 0.0
        self._times: deque[float] = deque(maxlen=MOST_FRAMES)

    @property
    def scale(self) -> float:
        """The share of the width and of the height to work at."""
        return self._scales[self._place]

    def spent(self, seconds: float) -> bool:
        """Tell how long a frame took at the present size; whether the size changes for the next."""
        self._times.append(seconds)
        passed = max(seconds, self._seconds)
        self._since += passed
        self._rose += passed
        if self._since < LOOK or len(self._times) < LEAST_FRAMES:
            return False
        usual = median(self._times)
        if usual > FULL * self._seconds and self._place + 1 < len(self._scales):
            # A rise that did not last is tried again later and later.
            self._patience = min(2 * self._patience, MOST_PATIENCE) if self._rose < 2 * LOOK else PATIENCE
            return self._go(self._fitting(usual))
        if self._place and self._since >= self._patience:
            larger = self._scales[self._place - 1]
            if usual * (larger / self.scale) ** 2 < ROOMY * self._seconds:
                self._rose = 0.0
                return self._go(self._place - 1)
        return False

    def restart(self) -> None:
        """Forget what was measured: another style runs now."""
        self._times.clear()
        self._since, self._patience = 0.0, PATIENCE

    def _fitting(self, usual: float) -> int:
        """The largest size below the present one that should do, or the smallest there is."""
        for place in range(self._place + 1, len(self._scales)):
            if usual * (self._scales[place] / self.scale) ** 2 < FULL * self._seconds:
                return place
        return len(self._scales) - 1

    def _go(self, place: int) -> bool:
        self._place = place
        self._times.clear()
        self._since = 0.0
        return True
