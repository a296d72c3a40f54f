"""What moves in a frame before a still camera: one mover or several, and how high they are."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.comic.analyze.action import subject_difference
from vidstyle.comic.analyze.features import Candidate, Foreground

_MIN_LARGE_MOVER_PX, _MIN_LARGE_MOVER_RATIO = 200, 0.5
"""Height from which a mover is large, in lines of the source, or relative to a small picture's height."""
_MIN_MOVED_DIFFERENCE = 0.75
"""Difference of what moves in two frames from which it has done something in between."""


def find_movers(action: Foreground) -> list[list[int]]:
    """Return left, top, width, height and area of each mover in the mask of an action, the largest first.

    Each has one cell more at every side than the mask.
    """
    joined = cv2.dilate(action.places.astype(np.uint8), np.ones((3, 3), np.uint8))
    found = cv2.connectedComponentsWithStats(joined)[2][1:].tolist()
    return sorted(found, key=lambda each: -each[4])


def has_large_mover(candidate: Candidate) -> bool:
    """Whether a mover is high enough to be shown in a close-up."""
    action = candidate.action
    if action is None or action.is_gone:
        return False
    highest = max((each[3] - 2 for each in find_movers(action)), default=0) / action.places.shape[0]
    height = candidate.shape[0]
    return highest * height >= min(_MIN_LARGE_MOVER_PX, _MIN_LARGE_MOVER_RATIO * height)


def has_lone_mover(candidate: Candidate) -> bool:
    """Whether a frame shows a single mover, which is large."""
    return (
        candidate.action is not None
        and len(find_movers(candidate.action)) == 1
        and has_large_mover(candidate)
    )


def has_several_movers(candidate: Candidate) -> bool:
    """Whether several things move in a frame without faces."""
    action = None if candidate.faces else candidate.action
    return action is not None and len(find_movers(action)) > 1


def has_moved(one: Candidate, other: Candidate) -> bool:
    """Whether the subject of a scene with a still camera is elsewhere in the second frame."""
    if one.scene != other.scene or one.action is None or other.action is None:
        return False
    return subject_difference(one.action, other.action) >= _MIN_MOVED_DIFFERENCE
