"""Reduced copies of windows, in which large faces are examined faster."""

from __future__ import annotations

from dataclasses import replace

from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.face_tracks import Face


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
