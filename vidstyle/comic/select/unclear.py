"""Chosen frames that are hard to read or tell little: soft, cluttered, murky and dark ones."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.select.frame_scores import (
    MAX_LEADING_SOFTNESS,
    clutter,
    face_softness,
    has_figure,
    has_subject,
    is_person,
)
from vidstyle.comic.select.importance import find_weakest

_MIN_STORY_PANELS, _MIN_STORY_SHARE = 4, 0.6
"""Number of panels, and share of the frames chosen, that are left at least by the removal of places, clutter,
murk and darkness: fewer tell no story, which is worse than a place that is hard to read."""

# Surplus places.
_MIN_FIGURES = 2
"""Number of panels with a face or a mover from which there are no more places than such panels."""
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


def count_story_panels(count: int) -> int:
    """Return how many of a number of chosen frames the removal of flawed ones leaves at least."""
    return max(_MIN_STORY_PANELS, round(_MIN_STORY_SHARE * count))


def find_soft(key_frames: Sequence[Candidate]) -> int | None:
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


def find_coarse(key_frames: Sequence[Candidate]) -> int | None:
    """Return the frame with the least detail if it is out of focus and another one is known not to be."""
    sharpest = max((each.resolution for each in key_frames if math.isfinite(each.resolution)), default=0.0)
    limit = min(_MAX_SOFT_RESOLUTION_PX, _MAX_SOFT_RESOLUTION_RATIO * sharpest)
    coarse = [number for number, each in enumerate(key_frames) if each.resolution < limit and not each.forced]
    return min(coarse, key=lambda number: key_frames[number].resolution, default=None)


def _is_sharp_close_up(candidate: Candidate) -> bool:
    """Whether a frame shows a face that is sharp; close-ups have few other edges."""
    return is_person(candidate) and face_softness(candidate) <= MAX_LEADING_SOFTNESS


def find_illegible(key_frames: Sequence[Candidate]) -> int | None:
    """Return the least important frame that is hard to read or tells little.

    The first frame stays if it shows the place where the film begins.
    """
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
    return find_weakest(key_frames, sorted(found))


def _surplus_places(key_frames: Sequence[Candidate], places: Sequence[int]) -> list[int]:
    """Return the places that tell nothing next to figures, or all of them if there are too many."""
    figures = len(key_frames) - len(places)
    if figures >= _MIN_FIGURES and len(places) > figures:
        return list(places)
    weak = [number for number in places if key_frames[number].importance < _MIN_PLACE_IMPORTANCE]
    return weak if figures else []


def _murky(key_frames: Sequence[Candidate]) -> list[int]:
    """Return the frames without a subject that are dark and have no distinct forms."""
    limit = _MIN_CLARITY_RATIO * float(np.median([each.clarity for each in key_frames]))
    return [
        number
        for number, each in enumerate(key_frames)
        if each.clarity < limit and each.light < _MAX_MURK_LIGHT and not has_subject(each)
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
