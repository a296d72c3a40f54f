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

_SHORTEST, _AIR = 0.4, 0.1
"""How far a tail stands out at least, and ends before what it points at, in sizes of the letters."""
_LONGEST = 12.0
"""A longer one might run over somebody else."""


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
    tips = _tips(bubble, mouth, with_face_room(face), kept)
    if tips and math.dist(tips[-1], bubble.middle) > _LONGEST * bubble.block.size + bubble.box.width / 2:
        return bubble
    # One that ends on half its way points at nobody.
    tails = (replace(bubble, tip=tip) for tip in reversed(tips[len(tips) // 2 :]))
    return next((tail for tail in tails if not _crosses(tail, kept)), bubble)


def _tips(bubble: Bubble, mouth: Point, face: Box, kept: Sequence[Box]) -> list[Point]:
    """Where the tail may end: outside the balloon, on its way until the face; nowhere if it is not free."""
    start, size = bubble.middle, bubble.block.size
    tips: list[Point] = []
    for part in np.linspace(0, 1, max(2, math.ceil(math.dist(start, mouth) / 2)))[:-1]:
        tip = start[0] + float(part) * (mouth[0] - start[0]), start[1] + float(part) * (mouth[1] - start[1])
        if _is_in(tip, bubble.box, _SHORTEST * size):
            continue
        if _is_in(tip, face, _AIR * size):
            return tips
        if any(_is_in(tip, box, _AIR * size) for box in kept):
            return []
        tips.append(tip)
    return tips


def _crosses(bubble: Bubble, kept: Sequence[Box]) -> bool:
    """Whether an edge of the tail runs through what is to be kept free."""
    root, tip, other = (np.array(point) for point in bubble.outline[:3])
    steps = np.linspace(0, 1, 40)[:, np.newaxis]
    points = np.concatenate([root + steps * (tip - root), other + steps * (tip - other)])
    return any(_is_in((x, y), box, 0) for x, y in points for box in kept)


def _is_in(point: Point, box: Box, room: float) -> bool:
    return box.left - room <= point[0] <= box.right + room and box.top - room <= point[1] <= box.bottom + room
