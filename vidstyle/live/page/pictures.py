"""Restyled frames as files that a browser shows."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.live.target import LiveFrame

LARGEST = (1920, 1080)
"""Width and height within which pictures are sent; more than that no window shows at once."""


def jpeg(frame: LiveFrame, quality: int) -> bytes:
    """The frame as JPEG, reduced to fit LARGEST; `quality`: 0 to 100."""
    picture = frame.picture
    scale = min(1.0, LARGEST[0] / picture.width, LARGEST[1] / picture.height)
    width, height = (max(1, round(side * scale)) for side in (picture.width, picture.height))
    pixels = picture.reformat(width=width, height=height, format="bgr24").to_ndarray()
    return _encoded(".jpg", pixels, [cv2.IMWRITE_JPEG_QUALITY, quality])


def png(frame: LiveFrame) -> bytes:
    """The frame as PNG, at its full size and without loss."""
    return _encoded(".png", frame.picture.to_ndarray(format="bgr24"), [])


def _encoded(ending: str, pixels: np.ndarray, options: list[int]) -> bytes:
    encoded, data = cv2.imencode(ending, pixels, options)
    assert encoded
    return data.tobytes()


class Quality:
    """How good the JPEG pictures for one browser are, by how long it takes to show one.

    Attributes:
        value: 0 to 100.

    >>> quality = Quality()
    >>> for _ in range(30):
    ...     quality.shown(0.2)
    >>> quality.value
    60
    """

    STEPS = (92, 85, 75, 60)
    SLOW, QUICK = 0.060, 0.030
    """Seconds until a picture is shown: above the first the quality falls, below the other it rises."""
    FEW, MANY = 8, 90
    """Pictures in a row, before it falls and before it rises."""

    def __init__(self) -> None:
        self._step = self._slow = self._quick = 0

    @property
    def value(self) -> int:
        """For the next picture."""
        return self.STEPS[self._step]

    def shown(self, seconds: float) -> None:
        """Tell how long a picture took."""
        self._slow = self._slow + 1 if seconds > self.SLOW else 0
        self._quick = self._quick + 1 if seconds < self.QUICK else 0
        if self._slow >= self.FEW:
            self._go(self._step + 1)
        elif self._quick >= self.MANY:
            self._go(self._step - 1)

    def _go(self, step: int) -> None:
        self._step = min(max(step, 0), len(self.STEPS) - 1)
        self._slow = self._quick = 0
