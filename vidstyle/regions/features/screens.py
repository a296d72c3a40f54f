"""Shade of a face as fine hatching or dots of full ink: a print has no gray."""

from __future__ import annotations

import numpy as np

from vidstyle.regions.boxes import Rectangle

MIN_PITCH_PX, PITCH_RATIO = 2.3, 1 / 55
"""Distance of lines and of dots, at least, and relative to the face's height: finer than the style's own, as
features are small."""
SCREEN_DEGREES = 45.0
"""Direction of lines and of rows of dots."""
CROSSED_RANGE = 0.6, 1.0
"""Shade from which a second set of lines crosses the first, and at which all is ink."""
EDGE_FACTOR = 1.5
"""Steepness of the edges of lines and dots, relative to a ramp over one pixel: fine ones would be gray."""


def screened(shade: np.ndarray, window: Rectangle, height: float, *, is_dotted: bool) -> np.ndarray:
    """Return coverage by ink in hatching or dots, H x W float32, 0..1.

    Args:
        shade: of a window of the page, H x W float32, 0..1.
        window: the window: marks stay where they are on the page.
        height: of the face in pixels.
        is_dotted: whether to print dots; otherwise lines.
    """
    pitch = max(MIN_PITCH_PX, PITCH_RATIO * height)
    turn = 2 * np.pi / pitch * np.exp(1j * np.radians(SCREEN_DEGREES))
    edge = EDGE_FACTOR * pitch / 2
    first = _wave(turn, shade.shape, window)
    if is_dotted:
        return _inked(shade, (2 - first - _wave(1j * turn, shade.shape, window)) / 4, edge)
    lines = _inked(shade, np.arccos(first) / np.float32(np.pi), edge)
    least, most = CROSSED_RANGE
    crossed = np.clip((shade - np.float32(least)) / np.float32(most - least), 0, 1)
    if not crossed.any():
        return lines
    second = np.arccos(_wave(1j * turn, shade.shape, window)) / np.float32(np.pi)
    return np.maximum(lines, _inked(crossed, second, edge))


def _wave(turn: complex, shape: tuple[int, ...], window: Rectangle) -> np.ndarray:
    """Return a wave with its radians per pixel across and down, H x W float32, -1..1."""
    rows = np.arange(window.top, window.top + shape[0], dtype=np.float32)[:, None]
    columns = np.arange(window.left, window.left + shape[1], dtype=np.float32)
    return np.cos(np.float32(turn.real) * columns + np.float32(turn.imag) * rows)


def _inked(shade: np.ndarray, order: np.ndarray, edge: float) -> np.ndarray:
    """Return where ink is: none without shade, everywhere at full shade; `order`: 0..1, first inked at 0."""
    level = shade * np.float32(1 + 1 / edge) - np.float32(0.5 / edge)
    return np.asarray(np.clip((level - order) * np.float32(edge) + np.float32(0.5), 0, 1), np.float32)
