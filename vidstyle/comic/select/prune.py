"""Removal of chosen frames that tell nothing new: twins, places without a subject, clutter and murk."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from functools import partial
from itertools import combinations, pairwise

import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.moving.poses import has_other_pose
from vidstyle.comic.analyze.similarity import SAME_SIMILARITY
from vidstyle.comic.select.choose import DISTINCT_PANELS, likeness
from vidstyle.comic.select.frame_scores import (
    MAX_LEADING_SOFTNESS,
    clutter,
    face_softness,
    has_figure,
    is_person,
    subject_strength,
)
from vidstyle.comic.select.twins import is_twin
from vidstyle.comic.select.views import (
    MAX_ARRIVAL_PANELS,
    find_repeated_view,
    is_later,
    look_different,
    shows_other_view,
    tells_story,
)

# Moments.
_MIN_MOMENT_SECONDS, _MIN_POSE_SECONDS, _MIN_CHANGE_SECONDS, _MIN_MOMENT_PANELS = 2.0, 1.2, 0.8, 2
"""Two frames of a scene within this time show one moment; the other values are for other poses, and for
frames that have nothing in common. Number of panels that are left at least."""

# Places.
_MIN_SUBJECT_STRENGTH = 0.1
"""Strength from which a frame has a subject, see `subject_strength`."""
_MIN_SCENE_SIMILARITY = 0.25
"""Similarity above which two frames of one scene, in which the camera may travel, show the same place."""

_MIN_FIGURE_RATIO, _MIN_FIGURES = 4, 2
"""From the second number of panels with a face or a mover on, one place is kept for each first number."""
_MIN_STORY_PANELS, _MIN_STORY_SHARE = 4, 0.6
"""Number of panels, and share of the frames chosen, that are left at least by the removal of places, clutter,
murk and darkness: fewer tell no story, which is worse than a place that is hard to read."""

_MAX_SUBJECT_CUT_SHARE = 0.6
"""A panel is removed if a larger part of its moving subject is outside of the picture."""
_MIN_PLACE_IMPORTANCE = 0.1
"""Importance below which a panel without a figure tells nothing next to panels with one."""

# Clutter.
_MAX_CLUTTER = 0.5
"""Clutter above which a panel is removed."""
_MAX_FIRST_CLUTTER = 0.7
"""The same for a place at the beginning, where the story takes place."""

# Soft pictures.
_MIN_SHARPNESS_RATIO = 0.6
"""Sharpness relative to the median of the panels below which one is soft."""
_MAX_SOFT_RESOLUTION_PX, _MAX_SOFT_RESOLUTION_RATIO = 225.0, 0.7
"""A picture is too soft for any panel below the first value, if another one has so much more detail."""
_MAX_STILL_MOTION = 0.05
"""Motion up to which a picture with a moving subject is soft because of its camera, not blurred by motion."""

# Murk.
_MIN_CLARITY_RATIO, _MAX_MURK_LIGHT = 0.5, 0.4
"""Clarity relative to the median, and mean luma, below which a panel without a subject is murk."""
_MAX_DARK_LIGHT, _MAX_DARK_CLARITY = 0.25, 0.5
"""Mean luma and clarity below which the dark hides what moves, though not a face."""


def prune(key_frames: Sequence[Candidate], least: int) -> list[Candidate]:
    """Return the frames without twins, further views of places, surplus places, clutter and murk.

    Of each pair, the more important one is kept; requested frames always are.

    Args:
        key_frames: in the order of time, framed.
        least: number of frames to keep at least.
    """
    kept = list(key_frames)
    story = max(_MIN_STORY_PANELS, round(_MIN_STORY_SHARE * len(kept)))
    for find in (*_FINDERS, partial(_find_illegible, story_panels=story)):
        while len(kept) > max(1, least):
            surplus = find(kept)
            if surplus is None:
                break
            kept.pop(surplus)
    return kept


def _weakest(key_frames: Sequence[Candidate], numbers: Sequence[int]) -> int | None:
    """Return the index of the least important one of these frames that was not requested."""
    free = [number for number in numbers if not key_frames[number].forced]
    return min(free, key=lambda number: key_frames[number].importance, default=None)


def _find_twin(key_frames: Sequence[Candidate]) -> int | None:
    like = likeness(key_frames, scenes=1)
    pairs = (
        pair
        for pair in combinations(range(len(key_frames)), 2)
        if pair[1] - pair[0] < DISTINCT_PANELS and not all(key_frames[each].forced for each in pair)
    )
    twins = (
        pair
        for pair in pairs
        if is_twin(key_frames[pair[0]], key_frames[pair[1]], float(like[pair[0], pair[1]]))
        and not _are_other_places(key_frames, pair)
    )
    return next((_weakest(key_frames, pair) for pair in twins), None)


def _are_other_places(key_frames: Sequence[Candidate], pair: tuple[int, int]) -> bool:
    one, other = (key_frames[number] for number in pair)
    return not (one.faces or other.faces) and shows_other_view(len(key_frames), one, other)


def _find_same_moment(key_frames: Sequence[Candidate]) -> int | None:
    """Return a frame that is too close in time to another one of its scene, if enough are left.

    Prefer the frame with the most close neighbours, so that as many moments as possible stay; then the frame
    whose place most others show; then the least important one.
    """
    if len(key_frames) <= _MIN_MOMENT_PANELS:
        return None
    crowded = Counter(
        number
        for before, (one, other) in enumerate(pairwise(key_frames))
        if one.scene == other.scene and _is_one_moment(one, other)
        for number in (before, before + 1)
        if not key_frames[number].forced
    )
    alike = Counter(number for pair in _pairs_of_one_place(key_frames) for number in pair)
    return max(
        crowded, key=lambda each: (crowded[each], alike[each], -key_frames[each].importance), default=None
    )


def _is_one_moment(one: Candidate, other: Candidate) -> bool:
    least = _MIN_POSE_SECONDS if has_other_pose(one, other) else _MIN_MOMENT_SECONDS
    least = _MIN_CHANGE_SECONDS if look_different(one, other) else least
    return other.time - one.time < least


def _find_repeated_place(key_frames: Sequence[Candidate]) -> int | None:
    """Return a frame without a subject whose place another such frame shows."""
    found = _pairs_of_one_place(key_frames)
    alike = max(found, key=found.__getitem__, default=())
    return _weakest(key_frames, alike)


def _pairs_of_one_place(key_frames: Sequence[Candidate]) -> dict[tuple[int, int], float]:
    """Return the pairs of frames without a subject that show one place, and how much they look alike."""
    places = [number for number, each in enumerate(key_frames) if not _has_subject(each)]
    like = likeness(key_frames, scenes=1)
    pairs = {
        pair: float(like[pair])
        for pair in combinations(places, 2)
        if not tells_story(len(key_frames), key_frames[pair[0]], key_frames[pair[1]])
    }
    return {pair: alike for pair, alike in pairs.items() if _is_same_place(key_frames, pair, alike)}


def _find_empty_place(key_frames: Sequence[Candidate]) -> int | None:
    """Return a frame without a figure whose place another frame of its scene shows with one."""
    if len(key_frames) <= MAX_ARRIVAL_PANELS and is_later(key_frames[0], key_frames[-1]):
        return None
    like = likeness(key_frames, scenes=1)
    empty = [
        number
        for number, each in enumerate(key_frames)
        if not has_figure(each)
        and any(
            has_figure(other) and _is_same_place(key_frames, (number, place), float(like[number, place]))
            for place, other in enumerate(key_frames)
            if other.scene == each.scene and not shows_other_view(len(key_frames), each, other)
        )
    ]
    return _weakest(key_frames, empty)


def _find_cut_subject(key_frames: Sequence[Candidate]) -> int | None:
    """Return a frame whose moving subject is mostly outside of it, if another frame shows a whole figure."""
    cut = [number for number, each in enumerate(key_frames) if _is_cut(each)]
    has_whole = any(has_figure(each) and not _is_cut(each) for each in key_frames)
    return _weakest(key_frames, cut) if has_whole else None


def _is_cut(candidate: Candidate) -> bool:
    action = None if candidate.faces else candidate.action
    return action is not None and action.cut > _MAX_SUBJECT_CUT_SHARE


def _is_same_place(key_frames: Sequence[Candidate], pair: tuple[int, int], like: float) -> bool:
    one, other = (key_frames[number] for number in pair)
    return like > (_MIN_SCENE_SIMILARITY if one.scene == other.scene else SAME_SIMILARITY)


def _find_soft(key_frames: Sequence[Candidate]) -> int | None:
    """Return the softest frame if the others are much sharper."""
    limit = _MIN_SHARPNESS_RATIO * float(np.median([each.sharpness for each in key_frames]))
    soft = [
        number
        for number, each in enumerate(key_frames)
        if each.sharpness < limit
        and not (each.forced or _is_sharp_close_up(each) or _is_still_with_subject(each))
    ]
    return min(soft, key=lambda number: key_frames[number].sharpness, default=None)


def _is_still_with_subject(candidate: Candidate) -> bool:
    """Whether a frame shows a subject in front of a still camera, and is not blurred by its motion.

    The films of some cameras are soft throughout, though everything in them can be recognized.
    """
    return (
        candidate.action is not None
        and candidate.motion <= _MAX_STILL_MOTION
        and candidate.resolution >= _MAX_SOFT_RESOLUTION_PX
    )


def _find_coarse(key_frames: Sequence[Candidate]) -> int | None:
    """Return the frame with the least detail if it is out of focus and another one is known not to be."""
    sharpest = max((each.resolution for each in key_frames if math.isfinite(each.resolution)), default=0.0)
    limit = min(_MAX_SOFT_RESOLUTION_PX, _MAX_SOFT_RESOLUTION_RATIO * sharpest)
    coarse = [number for number, each in enumerate(key_frames) if each.resolution < limit and not each.forced]
    return min(coarse, key=lambda number: key_frames[number].resolution, default=None)


def _is_sharp_close_up(candidate: Candidate) -> bool:
    """Whether a frame shows a face that is sharp; close-ups have few other edges."""
    return is_person(candidate) and face_softness(candidate) <= MAX_LEADING_SOFTNESS


def _find_illegible(key_frames: Sequence[Candidate], story_panels: int) -> int | None:
    """Return the least important frame that is hard to read or tells little, if enough others are left.

    The first frame stays if it shows the place where the film begins.
    """
    if len(key_frames) <= story_panels:
        return None
    places = [number for number, each in enumerate(key_frames) if not has_figure(each)]
    cluttered = [
        number
        for number, each in enumerate(key_frames)
        if clutter(each) > _MAX_CLUTTER and not _is_sharp_close_up(each)
    ]
    dark = [*_murky(key_frames), *_dark(key_frames)]
    found = {*cluttered, *dark, *_surplus_places(key_frames, places)}
    if 0 in places and 0 not in dark and clutter(key_frames[0]) <= _MAX_FIRST_CLUTTER:
        found -= {0}
    return _weakest(key_frames, sorted(found))


def _surplus_places(key_frames: Sequence[Candidate], places: Sequence[int]) -> list[int]:
    """Return the places that tell nothing next to figures, or all of them if there are too many."""
    figures = len(key_frames) - len(places)
    if figures >= _MIN_FIGURES and len(places) > max(1, figures // _MIN_FIGURE_RATIO):
        return list(places)
    weak = [number for number in places if key_frames[number].importance < _MIN_PLACE_IMPORTANCE]
    return weak if figures else []


def _murky(key_frames: Sequence[Candidate]) -> list[int]:
    """Return the frames without a subject that are dark and have no distinct forms."""
    limit = _MIN_CLARITY_RATIO * float(np.median([each.clarity for each in key_frames]))
    return [
        number
        for number, each in enumerate(key_frames)
        if each.clarity < limit and each.light < _MAX_MURK_LIGHT and not _has_subject(each)
    ]


def _dark(key_frames: Sequence[Candidate]) -> list[int]:
    """Return the frames with a mover but no face that the dark hides; none if too few others are left."""
    dark = [
        number
        for number, each in enumerate(key_frames)
        if each.light < _MAX_DARK_LIGHT
        and each.clarity < _MAX_DARK_CLARITY
        and has_figure(each)
        and not each.faces
    ]
    return dark if len(key_frames) - len(dark) >= _MIN_STORY_PANELS else []


def _has_subject(candidate: Candidate) -> bool:
    return subject_strength(candidate) >= _MIN_SUBJECT_STRENGTH


_FINDERS = (
    _find_twin,
    find_repeated_view,
    _find_cut_subject,
    _find_same_moment,
    _find_repeated_place,
    _find_empty_place,
    _find_soft,
    _find_coarse,
)
