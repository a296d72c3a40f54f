"""What moves in a frame before a still camera: one mover or several, and how high they are."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate, Foreground

_MIN_LARGE_MOVER_PX, _MIN_LARGE_MOVER_RATIO = 200, 0.5
"""Height from which a mover is large, in lines of the source, or relative to a small picture's height."""
_MIN_SEEN_MOVER_RATIO, _MIN_WIDE_SUBJECT_SHARE = 0.3, 0.3
"""Height of a mover, relative to the picture's, from which it can be seen well; and share of the picture that
the box of all movers covers at least in a wide view."""
_MAX_FEW_MOVERS = 3
"""Number of movers up to which each can be followed."""


def find_movers(action: Foreground) -> list[list[int]]:
    """Return left, top, width, height and area of each mover in the mask of an action, the largest first.

    Each has one cell more at every side than the mask.
    """
    joined = cv2.dilate(action.places.astype(np.uint8), np.ones((3, 3), np.uint8))
    found = cv2.connectedComponentsWithStats(joined)[2][1:].tolist()
    return sorted(found, key=lambda each: -each[4])


def has_large_mover(candidate: Candidate) -> bool:
    """Whether a mover is high enough to be shown in a close-up."""
    height = candidate.shape[0]
    return _highest_mover(candidate) >= min(_MIN_LARGE_MOVER_PX / height, _MIN_LARGE_MOVER_RATIO)


def is_lost_in_wide_view(candidate: Candidate) -> bool:
    """Whether the movers are high enough to be seen, but most of the picture shows nothing of them."""
    action, (height, width) = candidate.action, candidate.shape
    return (
        action is not None
        and _highest_mover(candidate) >= _MIN_SEEN_MOVER_RATIO
        and action.box.area < _MIN_WIDE_SUBJECT_SHARE * height * width
    )


def _highest_mover(candidate: Candidate) -> float:
    """Return the height of the highest mover relative to the picture's; 0 if nothing moves."""
    action = candidate.action
    if action is None or action.is_gone:
        return 0.0
    return float(max((each[3] - 2 for each in find_movers(action)), default=0) / action.places.shape[0])


def has_few_movers(candidate: Candidate) -> bool:
    """Whether a frame shows a few movers of which one is large."""
    return (
        candidate.action is not None
        and len(find_movers(candidate.action)) <= _MAX_FEW_MOVERS
        and has_large_mover(candidate)
    )


def has_several_movers(candidate: Candidate) -> bool:
    """Whether several things move in a frame without faces."""
    action = None if candidate.faces else candidate.action
    return action is not None and len(find_movers(action)) > 1
