"""Removal of chosen frames that tell nothing new: twins, places without a subject, clutter and murk."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from itertools import combinations, pairwise

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.moving.poses import has_other_pose
from vidstyle.comic.analyze.similarity import SAME_SIMILARITY
from vidstyle.comic.select.frame_scores import has_figure, has_subject
from vidstyle.comic.select.importance import find_weakest
from vidstyle.comic.select.likeness import likeness
from vidstyle.comic.select.movers import is_cut_off
from vidstyle.comic.select.panel_count import DISTINCT_PANELS
from vidstyle.comic.select.twins import is_twin
from vidstyle.comic.select.unclear import count_story_panels, find_coarse, find_illegible, find_soft
from vidstyle.comic.select.views import (
    MAX_ARRIVAL_PANELS,
    MIN_MOMENT_SECONDS,
    find_repeated_view,
    is_later,
    look_different,
    shows_other_view,
    tells_story,
)

# Moments.
_MIN_POSE_SECONDS, _MIN_UNLIKE_SECONDS, _MIN_MOMENT_PANELS = 1.2, 0.8, 2
"""Like `MIN_MOMENT_SECONDS`, for other poses and for frames that have nothing in common; and number of
panels that are left at least."""

# Places.
_MIN_SCENE_SIMILARITY = 0.25
"""Similarity above which two frames of one scene, in which the camera may travel, show the same place."""


def prune(key_frames: Sequence[Candidate], least: int) -> list[Candidate]:
    """Return the frames without twins, further views of places, surplus places, clutter and murk.

    Of each pair, the more important one is kept; requested frames always are.

    Args:
        key_frames: in the order of time, framed.
        least: number of frames to keep at least.
    """
    kept = _remove(key_frames, _FINDERS, max(1, least))
    return _remove(kept, [find_illegible], max(least, count_story_panels(len(key_frames))))


def _remove(
    key_frames: Sequence[Candidate],
    finders: Iterable[Callable[[Sequence[Candidate]], int | None]],
    least: int,
) -> list[Candidate]:
    """Return at least a number of frames, without those that one of the finders finds in turn."""
    kept = list(key_frames)
    for find in finders:
        while len(kept) > least:
            surplus = find(kept)
            if surplus is None:
                break
            kept.pop(surplus)
    return kept


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
    return next((find_weakest(key_frames, pair) for pair in twins), None)


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
    least = _MIN_POSE_SECONDS if has_other_pose(one, other) else MIN_MOMENT_SECONDS
    least = _MIN_UNLIKE_SECONDS if look_different(one, other) else least
    return other.time - one.time < least


def _find_repeated_place(key_frames: Sequence[Candidate]) -> int | None:
    """Return a frame without a subject whose place another such frame shows."""
    found = _pairs_of_one_place(key_frames)
    alike = max(found, key=found.__getitem__, default=())
    return find_weakest(key_frames, alike)


def _pairs_of_one_place(key_frames: Sequence[Candidate]) -> dict[tuple[int, int], float]:
    """Return the pairs of frames without a subject that show one place, and how much they look alike."""
    places = [number for number, each in enumerate(key_frames) if not has_subject(each)]
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
    return find_weakest(key_frames, empty)


def _find_cut_subject(key_frames: Sequence[Candidate]) -> int | None:
    """Return a frame whose moving subject is mostly outside of it, if another frame shows a whole figure."""
    cut = [number for number, each in enumerate(key_frames) if is_cut_off(each)]
    has_whole = any(has_figure(each) and not is_cut_off(each) for each in key_frames)
    return find_weakest(key_frames, cut) if has_whole else None


def _is_same_place(key_frames: Sequence[Candidate], pair: tuple[int, int], like: float) -> bool:
    one, other = (key_frames[number] for number in pair)
    return like > (_MIN_SCENE_SIMILARITY if one.scene == other.scene else SAME_SIMILARITY)


_FINDERS = (
    _find_twin,
    find_repeated_view,
    _find_cut_subject,
    _find_same_moment,
    _find_repeated_place,
    _find_empty_place,
    find_soft,
    find_coarse,
)
