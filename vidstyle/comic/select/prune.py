"""Removal of chosen frames that tell nothing new: twins, places without a subject, clutter and murk."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.similarity import SAME_SIMILARITY, color_similarity
from vidstyle.comic.select.choose import DISTINCT_PANELS, likeness
from vidstyle.comic.select.frame_scores import clutter, has_figure, subject_strength
from vidstyle.regions.boxes import Box

# Twins: the same picture or person again on a page, in the same size of shot.
_TWIN_SIMILARITY = 0.7
"""Similarity, reduced by moved subjects, from which two panels of one framing are twins."""
_MIN_TWIN_FACE_RATIO, _MAX_TWIN_SIZE_RATIO = 0.12, 1.4
"""Minimum height of a face that tells a person, relative to the picture's, and maximum ratio of two."""
_MIN_PERSON_SIMILARITY, _MIN_ROOM_SIMILARITY = 0.5, 0.15
"""Minimum histogram intersection of two views of a person, and minimum similarity of the pictures.

They were tuned on the 27 pairs of people on three pages of trailers: other people of similar colours are in
pictures with a similarity up to 0.11.
"""
_BODY_MARGIN_RATIOS = 0.5, 0.4, 1.5
"""Margins of a person around the face, in heights of the face: at each side, above and below."""

# Places.
_MIN_SUBJECT_STRENGTH = 0.1
"""Strength from which a frame has a subject, see `subject_strength`."""
_MIN_SCENE_SIMILARITY = 0.25
"""Similarity above which two frames of one scene, in which the camera may travel, show the same place."""
_MAX_PLACE_PANELS = 1
"""Maximum number of panels of a film of one place in which nothing is a subject."""

_MIN_FIGURE_RATIO, _MIN_FIGURES = 4, 3
"""From the second number of panels with a face or a mover on, one place is kept for each first number."""

# Clutter.
_MAX_CLUTTER, _MIN_CALM_PANELS = 0.5, 2
"""Clutter above which a panel is removed, and the number of panels that are left at least."""

# Soft pictures.
_MIN_SHARPNESS_RATIO = 0.6
"""Sharpness relative to the median of the panels below which one is soft."""

# Murk.
_MIN_CLARITY_RATIO, _MAX_MURK_LIGHT, _MIN_CLEAR_PANELS = 0.5, 0.4, 2
"""Clarity relative to the median, and mean luma, below which a panel without a subject is murk.

The third value is the number of panels that are left at least.
"""


def prune(key_frames: Sequence[Candidate], least: int) -> list[Candidate]:
    """Return the frames without twins, further views of places, surplus places, clutter and murk.

    Of each pair, the more important one is kept; requested frames always are.

    Args:
        key_frames: in the order of time, framed.
        least: number of frames to keep at least.
    """
    kept = list(key_frames)
    for find in _FINDERS:
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
    )
    return next((_weakest(key_frames, pair) for pair in twins), None)


def is_twin(one: Candidate, other: Candidate, like: float) -> bool:
    """Whether two frames show the same in the same framing; `like`: their similarity."""
    if one.framing != other.framing:
        return False
    return like > _TWIN_SIMILARITY or (like >= _MIN_ROOM_SIMILARITY and _is_same_shot_of_person(one, other))


def _is_same_shot_of_person(one: Candidate, other: Candidate) -> bool:
    sizes = [each.faces[0].height / each.shape[0] if each.faces else 0.0 for each in (one, other)]
    if min(sizes) < _MIN_TWIN_FACE_RATIO or max(sizes) > _MAX_TWIN_SIZE_RATIO * min(sizes):
        return False
    return color_similarity(_person(one), _person(other)) >= _MIN_PERSON_SIMILARITY


def _person(candidate: Candidate) -> np.ndarray:
    """Return the part of the thumbnail that shows head and body of the main face, H x W x 3 uint8."""
    (height, width), (rows, columns) = candidate.shape, candidate.thumbnail.shape[:2]
    face = candidate.faces[0]
    body = face.padded(*(ratio * face.height for ratio in _BODY_MARGIN_RATIOS))
    shown = body.intersection(Box(0, 0, width, height))
    top, bottom = int(shown.top * rows / height), int(np.ceil(shown.bottom * rows / height))
    left, right = int(shown.left * columns / width), int(np.ceil(shown.right * columns / width))
    return np.ascontiguousarray(candidate.thumbnail[top:bottom, left:right])


def _find_repeated_place(key_frames: Sequence[Candidate]) -> int | None:
    """Return a frame without a subject whose place another such frame shows."""
    places = [number for number, each in enumerate(key_frames) if not _has_subject(each)]
    like = likeness(key_frames, scenes=1)
    found = [pair for pair in combinations(places, 2) if _is_same_place(key_frames, pair, float(like[pair]))]
    if not found or (len(places) == len(key_frames) <= _MAX_PLACE_PANELS):
        return None
    alike = max(found, key=lambda pair: float(like[pair]))
    return _weakest(key_frames, alike)


def _is_same_place(key_frames: Sequence[Candidate], pair: tuple[int, int], like: float) -> bool:
    one, other = (key_frames[number] for number in pair)
    return like > (_MIN_SCENE_SIMILARITY if one.scene == other.scene else SAME_SIMILARITY)


def _find_clutter(key_frames: Sequence[Candidate]) -> int | None:
    """Return the most cluttered frame, if enough others are left."""
    if len(key_frames) <= _MIN_CALM_PANELS:
        return None
    cluttered = [
        number for number, each in enumerate(key_frames) if not each.forced and clutter(each) > _MAX_CLUTTER
    ]
    return max(cluttered, key=lambda number: clutter(key_frames[number]), default=None)


def _find_surplus_place(key_frames: Sequence[Candidate]) -> int | None:
    """Return the least important place of a story that has enough people and movers without it."""
    places = [number for number, each in enumerate(key_frames) if not has_figure(each)]
    figures = len(key_frames) - len(places)
    if figures < _MIN_FIGURES or len(places) <= max(1, figures // _MIN_FIGURE_RATIO):
        return None
    return _weakest(key_frames, places)


def _find_soft(key_frames: Sequence[Candidate]) -> int | None:
    """Return the softest frame if the others are much sharper, and enough are left."""
    if len(key_frames) <= _MIN_CALM_PANELS:
        return None
    limit = _MIN_SHARPNESS_RATIO * float(np.median([each.sharpness for each in key_frames]))
    soft = [number for number, each in enumerate(key_frames) if each.sharpness < limit and not each.forced]
    return min(soft, key=lambda number: key_frames[number].sharpness, default=None)


def _find_murk(key_frames: Sequence[Candidate]) -> int | None:
    if len(key_frames) <= _MIN_CLEAR_PANELS:
        return None
    limit = _MIN_CLARITY_RATIO * float(np.median([each.clarity for each in key_frames]))
    murky = [
        number
        for number, each in enumerate(key_frames)
        if each.clarity < limit
        and each.light < _MAX_MURK_LIGHT
        and not _has_subject(each)
        and not each.forced
    ]
    return min(murky, key=lambda number: key_frames[number].clarity, default=None)


def _has_subject(candidate: Candidate) -> bool:
    return subject_strength(candidate) >= _MIN_SUBJECT_STRENGTH


_FINDERS = _find_twin, _find_repeated_place, _find_clutter, _find_soft, _find_surplus_place, _find_murk
