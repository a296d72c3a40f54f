"""Frames of one view: the same place from the same side, though the camera has panned or cars have passed."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import cv2
import numpy as np

from vidstyle.comic.analyze.corners import show_same_view
from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.moving.poses import has_other_pose
from vidstyle.comic.analyze.similarity import DIFFERENT_SIMILARITY, similarity
from vidstyle.comic.select.frame_scores import has_figure, is_person
from vidstyle.comic.select.likeness import MAX_SPLIT_SCENES, view_similarity
from vidstyle.comic.select.movers import has_few_movers

_INNER_SIZE_PX, _SCALE_RATIOS = (30, 20), (0.85, 1.0, 1.18)
"""Width and height of the middle of a thumbnail that is searched in another one, and the scales tried."""
_MIN_VIEW_CORRELATION = 0.7
"""Correlation from which two frames are one view, if they look alike or belong to one scene: other pictures
of a trailer and of a film of joined clips have up to 0.68."""
_MAX_STORY_VIEWS = 4
"""Number of frames up to which a later moment of the same place is shown: the change is the story."""
MIN_MOMENT_SECONDS = 2.0
"""Minimum time between two frames of a scene that show two moments."""
_MAX_TRAVELLED_SIMILARITY = 0.65
"""Similarity up to which the camera has travelled between two moments.

On a film of ten seconds of a walk, views a third of the way apart have 0.3 to 0.62.
"""
MAX_ARRIVAL_PANELS = 2
"""Number of frames up to which a wide view and a later close-up of the same are both shown, or an empty place
and who has come to it: one picture alone tells no story."""


def find_repeated_view(key_frames: Sequence[Candidate]) -> int | None:
    """Return a frame whose view another one shows, of the nearest pair in time.

    It is the one without a mover, the close-up, or else the less important one; of two moments, the one in
    the middle of the film. Persons and a few large movers in another pose tell something new; other places of
    many cars only as long as there are few frames.
    """
    pairs = combinations(range(len(key_frames)), 2)
    for pair in sorted(pairs, key=lambda each: key_frames[each[1]].time - key_frames[each[0]].time):
        one, other = (key_frames[each] for each in pair)
        free = [each for each in pair if not key_frames[each].forced]
        if not free or not (_are_equal_places(one, other) or _is_surplus(len(key_frames), one, other)):
            continue
        if _shows_change(one, other):
            ends = 0, len(key_frames) - 1
            return min(free, key=lambda each: (each in ends, key_frames[each].importance))
        return min(free, key=lambda each: _worth(key_frames[each]))
    return None


def _worth(candidate: Candidate) -> tuple[bool, bool, float]:
    """Return how much a frame tells of its view: one with a mover more, and a close-up less."""
    has_mover = candidate.action is not None and not candidate.action.is_gone
    return has_mover, candidate.framing != "near", candidate.importance


def _are_equal_places(one: Candidate, other: Candidate) -> bool:
    """Whether two frames without a figure show the same view."""
    return not (has_figure(one) or has_figure(other)) and show_same_view(one.corners, other.corners)


def _is_surplus(count: int, one: Candidate, other: Candidate) -> bool:
    return _is_one_view(one, other) and not tells_story(count, one, other)


def tells_story(count: int, one: Candidate, other: Candidate) -> bool:
    """Whether two frames of one view are both shown on a page with this number of panels."""
    return (count <= _MAX_STORY_VIEWS and _shows_change(one, other)) or (
        count <= MAX_ARRIVAL_PANELS and _approaches(one, other)
    )


def _is_one_view(one: Candidate, other: Candidate) -> bool:
    if is_person(one) or is_person(other) or _tells_more(one, other):
        return False
    if view_correlation(one.thumbnail, other.thumbnail) < _MIN_VIEW_CORRELATION:
        return False
    return one.scene == other.scene or not look_different(one, other)


def _approaches(one: Candidate, other: Candidate) -> bool:
    """Whether the second frame is a later close-up of what the first one shows."""
    return (one.framing, other.framing) == ("wide", "near") and is_later(one, other)


def is_later(one: Candidate, other: Candidate) -> bool:
    """Whether the second frame is another moment than the first one."""
    return other.time - one.time >= MIN_MOMENT_SECONDS


def _shows_change(one: Candidate, other: Candidate) -> bool:
    """Whether two frames of a shot show different moments: others have come, or the camera has travelled."""
    return _are_moments(one, other) and (has_other_pose(one, other) or _looks_changed(one, other))


def shows_other_view(count: int, one: Candidate, other: Candidate) -> bool:
    """Whether a page with this number of panels shows both of two frames of a shot that look different."""
    return count <= _MAX_STORY_VIEWS and _are_moments(one, other) and _looks_changed(one, other)


def _are_moments(one: Candidate, other: Candidate) -> bool:
    is_one_shot = abs(one.scene - other.scene) <= MAX_SPLIT_SCENES
    return is_one_shot and (is_later(one, other) or is_later(other, one))


def _looks_changed(one: Candidate, other: Candidate) -> bool:
    return float(view_similarity([one, other])[0, 1]) <= _MAX_TRAVELLED_SIMILARITY


def look_different(one: Candidate, other: Candidate) -> bool:
    """Whether hardly anything of one frame is seen in the other."""
    return float(similarity([one.thumbnail, other.thumbnail])[0, 1]) <= DIFFERENT_SIMILARITY


def _tells_more(one: Candidate, other: Candidate) -> bool:
    """Whether the large movers look different in the second frame, or are in one of the frames only."""
    are_large = has_few_movers(one), has_few_movers(other)
    return has_other_pose(one, other) if all(are_large) else any(are_large)


def view_correlation(one: np.ndarray, other: np.ndarray) -> float:
    """Return the best correlation of the middle of one thumbnail with a part of the other, -1..1.

    Args:
        one: H x W x 3 uint8.
        other: of the same shape.
    """
    pair = [cv2.cvtColor(each, cv2.COLOR_RGB2LAB).astype(np.float32) for each in (one, other)]
    return max(
        float(cv2.matchTemplate(searched, _middle(shown, scale), cv2.TM_CCOEFF_NORMED).max())
        for shown, searched in (pair, pair[::-1])
        for scale in _SCALE_RATIOS
    )


def _middle(picture: np.ndarray, scale: float) -> np.ndarray:
    scaled = cv2.resize(picture, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    across, down = _INNER_SIZE_PX
    left, top = (scaled.shape[1] - across) // 2, (scaled.shape[0] - down) // 2
    return np.ascontiguousarray(scaled[top : top + down, left : left + across])
