"""Shade of a face as fine hatching or dots of full ink: a print has no gray."""

from __future__ import annotations

import numpy as np

from vidstyle.regions.boxes import Rectangle
from vidstyle.regions.features.ramps import ramp

MIN_PITCH_PX, PITCH_RATIO = 2.3, 1 / 55
"""Distance of lines and of dots, at least, and relative to the face's height: finer than the style's own, as
features are small."""
SCREEN_DEGREES = 45.0
"""Direction of lines and of rows of dots."""
CROSSED_RANGE = 0.6, 1.0
"""Shade from which a second set of lines crosses the first, and at which all is ink."""
EDGE_FACTOR = 1.5
"""Steepness of the edges of lines and dots, relative to a ramp over one pixel: fine ones would be gray."""


class ShadeScreen:
    """Hatching or dots in a window of a page; its marks have fixed positions on the page.

    Args:
        window: the window.
        height: of the face in pixels.
        is_dotted: whether to print dots; otherwise lines.
    """

    def __init__(self, window: Rectangle, height: float, *, is_dotted: bool) -> None:
        pitch = max(MIN_PITCH_PX, PITCH_RATIO * height)
        turn = 2 * np.pi / pitch * np.exp(1j * np.radians(SCREEN_DEGREES))
        first, second = (_wave(each, window) for each in (turn, 1j * turn))
        self._edge = EDGE_FACTOR * pitch / 2
        # In which order the pixels of each set of marks are inked.
        self._orders = (
            [(2 - first - second) / 4]
            if is_dotted
            else [np.arccos(each) / np.float32(np.pi) for each in (first, second)]
        )

    def inked(self, shade: np.ndarray) -> np.ndarray:
        """Return the coverage by ink that prints a shade of the window, both H x W float32, 0..1."""
        first, *crossing = self._orders
        crossed = ramp(shade, CROSSED_RANGE)
        marks = _inked(shade, first, self._edge), *(_inked(crossed, each, self._edge) for each in crossing)
        return np.maximum.reduce(marks)


def _wave(turn: complex, window: Rectangle) -> np.ndarray:
    """Return a wave with its radians per pixel across and down, H x W float32, -1..1."""
    rows = np.arange(window.top, window.bottom, dtype=np.float32)[:, None]
    columns = np.arange(window.left, window.right, dtype=np.float32)
    return np.cos(np.float32(turn.real) * columns + np.float32(turn.imag) * rows)


def _inked(shade: np.ndarray, order: np.ndarray, edge: float) -> np.ndarray:
    """Return where ink is: none without shade, everywhere at full shade; `order`: 0..1, first inked at 0."""
    level = shade * np.float32(1 + 1 / edge) - np.float32(0.5 / edge)
    return np.asarray(np.clip((level - order) * np.float32(edge) + np.float32(0.5), 0, 1), np.float32)
