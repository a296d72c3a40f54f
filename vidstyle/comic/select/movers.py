"""What moves in a frame before a still camera: one mover or several, where, and how high."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate, Foreground
from vidstyle.regions.boxes import Box

_MIN_LARGE_MOVER_PX, _MIN_LARGE_MOVER_RATIO = 200, 0.5
"""Height from which a mover is large, in lines of the source, or relative to a small picture's height."""
_MIN_NEAR_MOVER_PX = 85
"""Height from which a mover can be recognized in a close-up that enlarges it."""
_MIN_SEEN_MOVER_RATIO, _MIN_WIDE_SUBJECT_SHARE = 0.3, 0.3
"""Height of a mover, relative to the picture's, from which it can be seen well; and share of the picture that
the box of all movers covers at least in a wide view."""
_MAX_FEW_MOVERS = 3
"""Number of movers up to which each can be followed."""
_MAX_CUT_SHARE = 0.6
"""Part of a mover outside of the picture above which the edge cuts it off."""
_MIN_LARGEST_SHARE, _NEARLY_LARGEST_RATIO = 0.03, 0.8
"""Minimum share of the picture that a film's largest mover covers; and area from which another one is as
large, relative to it."""
_MOVER_MARGIN_RATIO, _MAX_MOVERS_SIDE_RATIO = 0.35, 0.5
"""Margin around one of several movers in longer sides of its box, as its coarse mask misses legs; and maximum
side of a close-up that others widen, relative to the picture's."""


def find_movers(action: Foreground) -> list[list[int]]:
    """Return left, top, width, height and area of each mover in the mask of an action, the largest first.

    Each has one cell more at every side than the mask.
    """
    joined = cv2.dilate(action.places.astype(np.uint8), np.ones((3, 3), np.uint8))
    found = cv2.connectedComponentsWithStats(joined)[2][1:].tolist()
    return sorted(found, key=lambda each: -each[4])


def main_mover(action: Foreground, whole: Box) -> Box:
    """Return the box of the largest mover with those next to it; of the whole action if there is only one."""
    movers = list[Box]()
    x, y = (whole.width / action.places.shape[1], whole.height / action.places.shape[0])
    for left, top, across, down, _ in find_movers(action):
        # Without the cell around it that the dilation adds.
        box = Box((left + 1) * x, (top + 1) * y, (left + across - 1) * x, (top + down - 1) * y)
        margin = _MOVER_MARGIN_RATIO * max(box.width, box.height)
        movers.append(box.padded(margin, margin, margin).intersection(whole))
    if len(movers) < 2:
        return action.box
    main = movers[0]
    for each in movers[1:]:
        joint = main.union(each)
        is_small = max(joint.width / whole.width, joint.height / whole.height) <= _MAX_MOVERS_SIDE_RATIO
        main = joint if is_small and each.intersection(main).area else main
    return main


def has_near_mover(candidate: Candidate) -> bool:
    """Whether a mover can be recognized in a close-up, though not in a wide view."""
    return _highest_mover(candidate) * candidate.shape[0] >= _MIN_NEAR_MOVER_PX


def has_large_mover(candidate: Candidate) -> bool:
    """Whether a mover is high enough to be shown in a close-up."""
    height = candidate.shape[0]
    return _highest_mover(candidate) >= min(_MIN_LARGE_MOVER_PX / height, _MIN_LARGE_MOVER_RATIO)


def widen(key_frame: Candidate) -> Candidate:
    """Return the key frame as a wide view; unchanged if its movers would be lost in it."""
    return key_frame if _is_lost_in_wide_view(key_frame) else replace(key_frame, framing="wide")


def _is_lost_in_wide_view(candidate: Candidate) -> bool:
    """Whether the movers of a frame without faces are high, but most of the picture shows nothing of them."""
    action, (height, width) = candidate.action, candidate.shape
    return (
        action is not None
        and not candidate.faces
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


def shows_largest_mover(candidates: Sequence[Candidate]) -> np.ndarray:
    """Return which frames of a film, without faces, show its largest mover at its full size: N bool."""
    areas = np.array([_whole_area(each) for each in candidates])
    return areas >= max(_MIN_LARGEST_SHARE, _NEARLY_LARGEST_RATIO * float(areas.max(initial=0.0)))


def is_cut_off(candidate: Candidate) -> bool:
    """Whether the edge cuts off most of what moves in a frame without faces."""
    action = None if candidate.faces else candidate.action
    return action is not None and action.cut > _MAX_CUT_SHARE


def _whole_area(candidate: Candidate) -> float:
    """Return the share of the picture that a mover covers; 0 if it is gone or cut off, or with faces."""
    action = None if candidate.faces else candidate.action
    if action is None or action.is_gone or is_cut_off(candidate):
        return 0.0
    return float(action.places.mean())
