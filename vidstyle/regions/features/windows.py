"""Windows of faces: their reduced copies, and common parts of their planes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.patches import plane_area


def reduced_window(face: Face, window: Rectangle, most: float) -> tuple[Face, Rectangle]:
    """Return a face and its window in a copy in which the face has at most `most` lines.

    A smaller face needs no copy: it and its window are returned.
    """
    factor = face.box.height / most
    if factor <= 1:
        return face, window
    width, height = (max(1, round(side / factor)) for side in (window.width, window.height))
    across, down = width / window.width, height / window.height
    left, top, right, bottom = face.box.moved(-window.left, -window.top)
    box = Box(left * across, top * down, right * across, bottom * down)
    return replace(face, box=box), Box(0, 0, width, height)


def common_parts(
    plane: np.ndarray, window: Rectangle, other: np.ndarray, place: Rectangle
) -> tuple[np.ndarray, np.ndarray]:
    """Return the common parts of two planes, which lie in `window` and at `place`, as views."""
    box = window.intersection(place)
    first, second = (
        each[plane_area(box.moved(-at.left, -at.top), (1, 1))]
        for each, at in ((plane, window), (other, place))
    )
    return first, second
