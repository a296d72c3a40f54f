"""How large a picture the server restyles while values are dragged."""

from __future__ import annotations

WORKING_SIDES_PX = (1440, 1080, 900, 720, 600, 540, 480, 432, 360, 300, 270, 240, 216, 180)
"""Shorter sides of pictures, from the largest."""
MAX_SECONDS = 0.06
"""The longest that restyling may take, so that the picture follows a slider within 0.1 s."""


class WorkingSize:
    """Chooses a size by the time that the last picture took.

    >>> size = WorkingSize()
    >>> size.measured(640 * 360, 0.24)
    >>> size.side(720, 16 / 9), size.side(720, 16 / 9, seconds=0.6)
    (180, 540)
    >>> size.measured(320 * 180, 0.006)
    >>> size.side(720, 16 / 9)
    540
    """

    def __init__(self) -> None:
        self._seconds_per_pixel = 5e-7

    def measured(self, pixels: int, seconds: float) -> None:
        """Record what a picture took."""
        self._seconds_per_pixel = seconds / pixels

    def side(self, most: int, aspect: float, seconds: float = MAX_SECONDS) -> int:
        """The shorter side of the next picture.

        Args:
            most: the largest that is wanted.
            aspect: longer side over shorter.
            seconds: how long it may take.
        """
        fitting = (
            side for side in WORKING_SIDES_PX if side * side * aspect * self._seconds_per_pixel <= seconds
        )
        return min(most, next(fitting, WORKING_SIDES_PX[-1]))
