"""The size of previews that the server renders while a slider moves."""

from __future__ import annotations

WORKING_SIDES_PX = (1440, 1080, 900, 720, 600, 540, 480, 432, 360, 300, 270, 240, 216, 180)
"""Shorter sides of previews, from large to small."""
MAX_SECONDS = 0.06
"""Maximum rendering time, so that the preview follows a slider within 0.1 s."""
MIN_REDUCTION = 1.25
"""Least ratio of the sides of the final picture and of a draft: a larger draft hardly saves time."""


class WorkingSize:
    """Selects the size of the next preview from the time of the last one.

    >>> size = WorkingSize()
    >>> size.record(640 * 360, 0.24)
    >>> size.side(720, 16 / 9)
    180
    >>> size.record(320 * 180, 0.006)
    >>> size.side(720, 16 / 9)
    540
    """

    def __init__(self) -> None:
        self._seconds_per_pixel = 5e-7

    def record(self, pixels: int, seconds: float) -> None:
        """Record the rendering time of a picture."""
        self._seconds_per_pixel = seconds / pixels

    def side(self, most: int, aspect: float, least: int = 0) -> int:
        """Return the shorter side of the next preview.

        Args:
            most: the largest useful size.
            aspect: longer side divided by shorter side.
            least: the smallest useful size, however long it takes.
        """
        fitting = (
            side for side in WORKING_SIDES_PX if side * side * aspect * self._seconds_per_pixel <= MAX_SECONDS
        )
        side = max(least, next(fitting, WORKING_SIDES_PX[-1]))
        return most if side * MIN_REDUCTION > most else side
