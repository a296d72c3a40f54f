"""Tails of balloons, which say who speaks."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vidstyle.comic.bubble import Bubble, Point
from vidstyle.comic.moment import Box

FACE_ROOM = 0.06
"""Around faces, in sides of them: nothing is written there."""


def with_face_room(face: Box) -> Box:
    """A face, and what is about it that must not be covered."""
    across, down = FACE_ROOM * face.width, FACE_ROOM * face.height
    return Box(face.left - across, face.top - down, face.right + across, face.bottom + down)


def with_tail(bubble: Bubble, face: Box | None, kept: Sequence[Box]) -> Bubble:
    """A balloon with a tail towards the face, as long as nothing is in its way.

    Args:
        kept: where no tail may be: all faces with room about them, and other balloons.
    """
    if bubble.kind != "balloon" or face is None:
        return bubble
    mouth = (face.left + face.right) / 2, face.top + 0.75 * face.height
    start, size, tip = bubble.middle, bubble.block.size, None
    length = math.dist(start, mouth)
    for part in np.linspace(0, 1, max(2, math.ceil(length / 2)))[:-1]:
        point = start[0] + part * (mouth[0] - start[0]), start[1] + part * (mouth[1] - start[1])
        if _is_in(point, bubble.box, 0):
            continue
        if any(_is_in(point, box, 0.1 * size) for box in kept):
            break
        tip = point
    if tip is None or not _stands_out(tip, bubble, 0.4 * size):
        return bubble
    return replace(bubble, tip=tip)


def _is_in(point: Point, box: Box, room: float) -> bool:
    return box.left - room <= point[0] <= box.right + room and box.top - room <= point[1] <= box.bottom + room


def _stands_out(tip: Point, bubble: Bubble, least: float) -> bool:
    return not _is_in(tip, bubble.box, least)
