"""Choice of key frames: scores relative to the film, and the candidates with the best total."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.analyze.moving.poses import MIN_POSE_CHANGE, pose_changes
from vidstyle.comic.analyze.similarity import SAME_SIMILARITY, TRAVEL_WEIGHT, compare_views, similarity
from vidstyle.comic.select.best_path import (
    FORCED_SCORE,
    film_places,
    find_best_path,
    pair_steps,
    similarity_costs,
)
from vidstyle.comic.select.film_thirds import film_thirds
from vidstyle.comic.select.frame_scores import scene_values, scores
from vidstyle.comic.select.movers import shows_largest_mover

# The number of panels, and of candidates among which they are chosen.
MIN_DEFAULT_PANELS, MAX_DEFAULT_PANELS = 1, 40
"""Range of the default number of panels."""
MAX_POOL_CANDIDATES = 400
"""Maximum number of candidates considered, or twice the number of panels: the best of each part."""
DISTINCT_PANELS = 9
"""If the number of panels is free, no two of this many successive panels look nearly the same: a page."""
MIN_MOVING_PANELS = 3
"""With fewer panels, a film with motion is shown by frames at regular intervals, though they look alike."""
BEAT_SECONDS, _MAX_BEAT_PANELS, _MIN_BEAT_PANELS = 0.9, 3, 2
"""Interval of these frames, and their maximum and minimum number: a wide view and a close-up."""
_MOMENT_SIMILARITY, _BEAT_SIMILARITY = 0.62, 0.8
"""Maximum similarity of moments in front of a still camera, and of beats beyond their minimum number."""
_MIN_FILM_MOTION = 0.02
"""Motion above which a film is not still."""

_MOVED_SUBJECT_WEIGHT, _MOVED_SUBJECT_SCENES_WEIGHT = 0.5, 0.2
"""Subtracted from the similarity of two frames of a scene if the pose or place of the subject differs.

The first value is for films of up to `_MAX_STORY_SCENES` scenes.
"""
_MAX_STORY_SCENES, _STORY_PANELS, _MIN_STORY_SECONDS = 3, 6, 1.4
"""Up to this number of scenes, other poses are other moments: up to this number of panels, each for at least
this duration."""

MAX_SPLIT_SCENES = 1
"""Distance of two scenes that may be one shot, as a travelling camera can look like a dissolve."""

_SPEAKER_SCORE = 0.4
"""Score of a frame with a face while someone speaks."""
_LARGEST_MOVER_SCORE = 1.0
"""Score of the largest mover of a film: what comes near for a moment is what the film is about."""
_SEED_SCORE = 0.6
"""Maximum that a seed adds to the score of a frame: less than speech with a face in a close-up."""
_MAX_SEED_PANELS = 1
"""Maximum number of panels that a seed adds to the default number, or takes from it."""
_MAX_SUBJECT_CUT_SHARE = 0.6
"""Maximum part of a moving subject that the edge may cut off, while its scene has other frames."""


def default_panels(scenes: int, seconds: float) -> int:
    """Return the default number of panels of a film; it grows with scenes and duration, ever more slowly.

    >>> default_panels(1, 5), default_panels(26, 70), default_panels(1500, 7200)
    (3, 12, 40)
    """
    return min(
        MAX_DEFAULT_PANELS,
        max(MIN_DEFAULT_PANELS, round(1.5 * math.sqrt(scenes) + math.log2(1 + seconds / 4))),
    )


def choose(
    survey: Survey,
    forced: Sequence[Candidate],
    panels: int | None,
    min_panels: int = 0,
    spoken: Sequence[tuple[float, float]] = (),
    seed: int = 0,
) -> list[Candidate]:
    """Choose the frames to show, in chronological order.

    Args:
        survey: the candidates, see `usable_candidates`; those that the subject of their shot has left, or is
            leaving, are chosen only if there are no others.
        forced: requested frames, which are always chosen.
        panels: total number of panels; None: `default_panels`, or fewer if pictures would look the same, but
            at least a few if the film moves.
        min_panels: minimum number if `panels` is None.
        spoken: start and end of speech in seconds: frames with faces are preferred there.
        seed: random seed: 0 gives the best frames, other seeds give others that are nearly as good.
    """
    seen = _with_whole_subjects(usable_candidates(survey.candidates))
    times = {each.time for each in forced}
    pool = sorted([*forced, *(each for each in seen if each.time not in times)], key=lambda each: each.time)
    if not pool:
        return []
    values = scores(pool, scene_values(survey)) + [FORCED_SCORE * each.forced for each in pool]
    values += [_SPEAKER_SCORE * bool(each.faces and _is_in_spans(each.time, spoken)) for each in pool]
    values += _LARGEST_MOVER_SCORE * shows_largest_mover(pool)
    random = np.random.default_rng(seed)
    values += _SEED_SCORE * random.random(len(pool)) if seed else 0.0
    kept = _keep_best_per_part(pool, values, survey, max(MAX_POOL_CANDIDATES, 2 * (panels or 0)))
    pool, values = [pool[number] for number in kept], values[kept]
    scenes, places = len(survey.scene_starts), film_places(pool, survey)
    like = likeness(pool, scenes, sees_travel=scenes <= _MAX_STORY_SCENES and not survey.is_folder)
    wanted = _count_panels(survey, like, len(forced), panels, min_panels)
    if seed and panels is None and not survey.is_folder:
        varied = wanted + int(random.integers(-_MAX_SEED_PANELS, _MAX_SEED_PANELS, endpoint=True))
        wanted = min(len(pool), max(MIN_DEFAULT_PANELS, min_panels, len(forced), varied))
    thirds = None if survey.is_folder else np.array(film_thirds(pool, survey.seconds))
    usual = min(len(pool), default_panels(1, survey.seconds))
    beats = _count_beats(survey, len(pool))
    tried = [(wanted, 1.0)] if panels is not None else _attempts(wanted, beats, usual)
    chosen = list[int]()
    for count, limit in tried:
        if count < len(forced):
            break
        steps = pair_steps(pool, places, count)
        chosen = find_best_path(values, steps, similarity_costs(like), places, count, thirds)
        if not _has_repeats(like, chosen, limit):
            break
    return [pool[number] for number in chosen]


def _attempts(wanted: int, beats: int, usual: int) -> list[tuple[int, float]]:
    """Return numbers of panels to try, each with the similarity that no two of them may exceed.

    Args:
        wanted: number of panels with different pictures.
        beats: see `_count_beats`.
        usual: number of panels of a film of this duration.
    """
    if beats == 1:
        return [(count, SAME_SIMILARITY) for count in range(wanted, 0, -1)]
    several = [(count, SAME_SIMILARITY) for count in range(wanted, MIN_MOVING_PANELS - 1, -1)]
    moments = [(count, _MOMENT_SIMILARITY) for count in range(usual, MIN_MOVING_PANELS, -1)]
    return several + moments + [(count, _BEAT_SIMILARITY) for count in range(beats, _MIN_BEAT_PANELS - 1, -1)]


def usable_candidates(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates that panels may show: without defects, if the film has any.

    A film without a single good frame shows combed ones, then those in which the decoder reported errors,
    if none of its frames has visible ones, then blurred ones. Blank and test pictures, visible damage and
    blends of two shots are never shown.
    """
    shown = [
        each
        for each in candidates
        if not (each.blank or each.test_picture or each.broken or each.in_transition)
    ]
    whole = [each for each in shown if not each.damaged]
    if any(each.broken for each in candidates):
        shown = whole
    steady = [each for each in whole if not each.blurred]
    sharp = [each for each in shown if not each.blurred]
    return [each for each in steady if not each.combed] or steady or sharp or shown


def _with_whole_subjects(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates without those whose subject has left the picture or is cut off by its edge.

    Of a scene that has only such candidates, those with a cut subject are kept; or else all, if a film has
    nothing else. A person whose face is seen has not left: only the hands have moved.
    """
    shown = [each for each in candidates if each.faces or not (each.action and each.action.is_gone)]
    shown = shown or list(candidates)
    whole = [
        each for each in shown if each.faces or not (each.action and each.action.cut > _MAX_SUBJECT_CUT_SHARE)
    ]
    scenes = {each.scene for each in whole}
    return [each for each in shown if each.scene not in scenes] + whole


def _is_in_spans(time: float, spans: Sequence[tuple[float, float]]) -> bool:
    return any(start <= time <= end for start, end in spans)


def likeness(pool: Sequence[Candidate], scenes: int, sees_travel: bool = False) -> np.ndarray:
    """Return the similarity of frames, N x N; lower for other poses before a still camera.

    `sees_travel`: whether it is the one of `view_similarity`.
    """
    like = view_similarity(pool) if sees_travel else similarity([each.thumbnail for each in pool])
    weight = _MOVED_SUBJECT_WEIGHT if scenes <= _MAX_STORY_SCENES else _MOVED_SUBJECT_SCENES_WEIGHT
    return np.asarray(like - weight * np.minimum(1, pose_changes(pool) / MIN_POSE_CHANGE))


def view_similarity(frames: Sequence[Candidate]) -> np.ndarray:
    """Return the similarity of frames, N x N; lower for places between which the camera of a shot travels.

    Of people and movers, the pose tells what has changed.
    """
    like, travelled = compare_views([each.thumbnail for each in frames])
    scenes, is_place = (
        np.array([each.scene for each in frames]),
        np.array([not (each.faces or each.action) for each in frames]),
    )
    is_shot = np.abs(np.subtract.outer(scenes, scenes)) <= MAX_SPLIT_SCENES
    return like - TRAVEL_WEIGHT * travelled * (is_shot & np.logical_and.outer(is_place, is_place))


def _count_beats(survey: Survey, most: int) -> int:
    """Return the number of panels of a film with few different pictures: 1 if nothing moves."""
    moves = not survey.is_folder and any(each.motion > _MIN_FILM_MOTION for each in survey.candidates)
    return max(1, min(_MAX_BEAT_PANELS, most, round(survey.seconds / BEAT_SECONDS))) if moves else 1


def _count_panels(survey: Survey, like: np.ndarray, forced: int, panels: int | None, min_panels: int) -> int:
    if panels is not None:
        return min(len(like), max(forced, panels))
    distinct: list[int] = []
    for number in range(len(like)):
        if not (like[number, distinct[-DISTINCT_PANELS:]] > SAME_SIMILARITY).any():
            distinct.append(number)
    scenes = len(survey.scene_starts)
    usual = MAX_DEFAULT_PANELS if survey.is_folder else default_panels(scenes, survey.seconds)
    if scenes <= _MAX_STORY_SCENES:
        usual = max(usual, min(_STORY_PANELS, int(survey.seconds / _MIN_STORY_SECONDS)))
    return max(forced, min(max(usual, min_panels), MAX_DEFAULT_PANELS, len(distinct)))


def _has_repeats(like: np.ndarray, chosen: Sequence[int], limit: float) -> bool:
    """Whether two frames within `DISTINCT_PANELS` successive panels have a similarity above a limit."""
    near = np.tri(len(chosen), k=DISTINCT_PANELS - 1, dtype=bool) & ~np.tri(len(chosen), dtype=bool)
    return bool((like[np.ix_(chosen, chosen)] > limit)[near].any())


def _keep_best_per_part(
    pool: Sequence[Candidate], values: np.ndarray, survey: Survey, most: int
) -> np.ndarray:
    """Return the indices of the candidates considered: the best of each part of the film."""
    parts = np.minimum((film_places(pool, survey) * most / 2).astype(int), most // 2 - 1)
    kept: dict[int, list[int]] = {}
    for number in np.argsort(-values, kind="stable"):
        part = kept.setdefault(int(parts[number]), [])
        if len(part) < 2 or pool[number].forced:
            part.append(int(number))
    return np.array(sorted(number for part in kept.values() for number in part))
