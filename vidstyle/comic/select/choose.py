"""Choice of key frames: scores relative to the film, and the candidates with the best total."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vidstyle.comic.analyze.action import subject_difference
from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.analyze.similarity import DIFFERENT_SIMILARITY, SAME_SIMILARITY, similarity

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

# Costs of pairs of panels, relative to the scores of frames, which are 0..1.
_FORCED_SCORE, _TOO_CLOSE_COST = 1000.0, 50.0
"""Score of a requested frame, and cost of two frames too close together in time.

Each outweighs the sum of all terms after it.
"""
_MIN_PANEL_SECONDS = 0.4
"""Minimum time between two panels."""
_SIMILAR_COST, _EQUAL_COST = 2.0, 20.0
"""Costs of two neighbours that look nearly the same, and of two equal ones.

As scores are 0..1, such neighbours are chosen only if there are no other frames.
"""
LOOKBACK_PANELS = 12
"""Number of preceding panels with which each one is compared: two pages."""
_SIMILAR_HALF_PANELS = 3
"""Distance in panels at which the cost of similarity is half as high."""
_SAME_SCENE_COST, _UNEVEN_PACE_WEIGHT = 0.2, 0.25
"""Cost of staying in a scene, and weight of an uneven pace."""
_MOVED_SUBJECT_WEIGHT, _MOVED_SUBJECT_SCENES_WEIGHT = 0.5, 0.2
"""How much less alike two frames of a scene are whose subject has moved elsewhere.

The first value is for a film of one scene, which has nothing else to tell.
"""

# Scores of frames.
_FILM_RANK_WEIGHT, _SCENE_RANK_WEIGHT = 0.15, 0.25
"""Weights of the rank of a frame's sharpness in the film and in its scene."""
_CLARITY_WEIGHT, _FACE_WEIGHT, _SCENE_WEIGHT = 0.6, 0.25, 0.3
"""Weights of clarity, of the largest face and of the value of the scene."""
_MIN_GROUP_INTERSECTION = 0.65
"""Scenes with a higher histogram intersection form a group, such as the shots of a speaker in a dialogue."""
_MAX_BLUR_COST = 0.5
"""Maximum cost of blur."""
_MIN_SHARPNESS_RATIO, _MIN_SOFT_SCENE_RATIO = 0.8, 0.4
"""A frame is blurred below this fraction of the median sharpness; the second value is for soft scenes.

The fractions are below 1 as close-ups of faces have few edges.
"""
_MIN_CLARITY = 0.35
"""Clarity below which sharpness counts less, as there is little to see."""
_MAX_MOTION_COST, _MAX_COST_MOTION = 0.5, 0.6
"""Maximum cost of motion, and the motion that has it: motion blur beyond what edges show."""
_SPEAKER_SCORE = 0.4
"""Score of a frame with a face while someone speaks."""
_ACTION_SCORE, _MAX_CUT_SUBJECT_COST = 0.3, 0.8
"""Score of a moving subject, and maximum cost of one that the picture's edge cuts off."""
_SEED_SCORE = 0.3
"""Maximum that a seed adds to the score of a frame: less than speech with a face in a close-up."""
_MAX_SEED_PANELS = 1
"""Maximum number of panels that a seed adds to the default number, or takes from it."""
# The importance of chosen frames.
_SUBJECT_WEIGHT, _SCENE_SHARE_WEIGHT, _QUALITY_WEIGHT, _FORCED_WEIGHT = 0.8, 0.3, 0.25, 0.25
"""Weights of the subject, of the frame's share of its scene, of its quality, and of a request."""
_FACE_SUBJECT_SCORE, _ACTION_SUBJECT_SCORE, _SALIENT_SUBJECT_SCORE = 0.6, 0.8, 0.4
"""Strength of a small face, of something that moves, and of the smallest salient area."""
_MAX_SUBJECT_AREA_SHARE = 0.5
"""Share of the picture from which a salient area is no subject."""
_MAX_SUBJECT_CUT_SHARE = 0.6
"""Maximum part of a moving subject that the edge may cut off, while its scene has other frames."""
_FULL_SCORE_FACE_SHARE = 0.12
"""Share of the picture from which a larger face scores no higher."""


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
    values = scores(pool, scene_values(survey)) + [_FORCED_SCORE * each.forced for each in pool]
    values += [_SPEAKER_SCORE * bool(each.faces and _is_in_spans(each.time, spoken)) for each in pool]
    random = np.random.default_rng(seed)
    values += _SEED_SCORE * random.random(len(pool)) if seed else 0.0
    kept = _keep_best_per_part(pool, values, survey, max(MAX_POOL_CANDIDATES, 2 * (panels or 0)))
    pool, values = [pool[number] for number in kept], values[kept]
    like, places = likeness(pool, len(survey.scene_starts)), _places(pool, survey)
    wanted = _count_panels(survey, like, len(forced), panels, min_panels)
    if seed and panels is None and not survey.is_folder:
        varied = wanted + int(random.integers(-_MAX_SEED_PANELS, _MAX_SEED_PANELS, endpoint=True))
        wanted = min(len(pool), max(MIN_DEFAULT_PANELS, min_panels, len(forced), varied))
    usual = min(len(pool), default_panels(1, survey.seconds))
    beats = _count_beats(survey, len(pool))
    tried = [(wanted, 1.0)] if panels is not None else _attempts(wanted, beats, usual)
    chosen = list[int]()
    for count, limit in tried:
        if count < len(forced):
            break
        steps = _steps(pool, places, count)
        chosen = _find_best_path(values, steps, _similarity_costs(like), places, count)
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

    A film without a single good frame shows combed ones, then those in which the decoder reported errors
    that are not visible, then blurred ones. Blank and test pictures, visible damage and blends of two shots
    are never shown.
    """
    shown = [
        each
        for each in candidates
        if not (each.blank or each.test_picture or each.broken or each.in_transition)
    ]
    whole = [each for each in shown if not each.damaged]
    steady = [each for each in whole if not each.blurred]
    sharp = [each for each in shown if not each.blurred]
    return [each for each in steady if not each.combed] or steady or sharp or shown


def _with_whole_subjects(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Return the candidates without those whose subject has left the picture or is cut off by its edge.

    Of a scene that has only such candidates, those with a cut subject are kept; or else all, if a film has
    nothing else.
    """
    shown = [each for each in candidates if not (each.action and each.action.is_gone)] or candidates
    whole = [each for each in shown if not (each.action and each.action.cut > _MAX_SUBJECT_CUT_SHARE)]
    scenes = {each.scene for each in whole}
    return [each for each in shown if each.scene not in scenes] + whole


def _is_in_spans(time: float, spans: Sequence[tuple[float, float]]) -> bool:
    return any(start <= time <= end for start, end in spans)


def likeness(pool: Sequence[Candidate], scenes: int) -> np.ndarray:
    """Return the similarity of frames, N x N; lower for a still camera whose subject is in another place."""
    like = similarity([each.thumbnail for each in pool])
    weight = _MOVED_SUBJECT_WEIGHT if scenes == 1 else _MOVED_SUBJECT_SCENES_WEIGHT
    for first, one in enumerate(pool):
        for second, other in enumerate(pool[:first]):
            if one.action and other.action and one.scene == other.scene:
                moved = subject_difference(one.action, other.action)
                like[[first, second], [second, first]] -= weight * moved
    return like


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
    usual = (
        MAX_DEFAULT_PANELS if survey.is_folder else default_panels(len(survey.scene_starts), survey.seconds)
    )
    return max(forced, min(max(usual, min_panels), MAX_DEFAULT_PANELS, len(distinct)))


def _has_repeats(like: np.ndarray, chosen: Sequence[int], limit: float) -> bool:
    """Whether two frames within `DISTINCT_PANELS` successive panels have a similarity above a limit."""
    near = np.tri(len(chosen), k=DISTINCT_PANELS - 1, dtype=bool) & ~np.tri(len(chosen), dtype=bool)
    return bool((like[np.ix_(chosen, chosen)] > limit)[near].any())


def _places(pool: Sequence[Candidate], survey: Survey) -> np.ndarray:
    """Return positions in the film, 0..1: the mean of time and scene, so that short scenes count too."""
    times = np.array([each.time for each in pool]) / max(survey.seconds, 1e-6)
    scenes = np.array([each.scene + 0.5 for each in pool]) / len(survey.scene_starts)
    return np.clip((times + (scenes if len(survey.scene_starts) > 1 else times)) / 2, 0, 1)


def _keep_best_per_part(
    pool: Sequence[Candidate], values: np.ndarray, survey: Survey, most: int
) -> np.ndarray:
    """Return the indices of the candidates considered: the best of each part of the film."""
    parts = np.minimum((_places(pool, survey) * most / 2).astype(int), most // 2 - 1)
    kept: dict[int, list[int]] = {}
    for number in np.argsort(-values, kind="stable"):
        part = kept.setdefault(int(parts[number]), [])
        if len(part) < 2 or pool[number].forced:
            part.append(int(number))
    return np.array(sorted(number for part in kept.values() for number in part))


def _find_best_path(
    values: np.ndarray, steps: np.ndarray, prices: np.ndarray, places: np.ndarray, wanted: int
) -> list[int]:
    """Return the indices of the best `wanted` candidates, by dynamic programming over time.

    Maximizes the sum of values and steps minus the prices of pairs. As prices depend on several earlier
    choices, this is a beam search that keeps the best path to each candidate; its result is nearly optimal.

    Args:
        values: the score of each candidate.
        steps: the score of going from one candidate (row) to a later one (column).
        prices: the cost of two candidates as neighbours.
        places: see `_places`.
        wanted: number of candidates to choose.
    """
    totals = values - _UNEVEN_PACE_WEIGHT * (2 * wanted * places - 1).clip(-2, 2) ** 2 / 4
    ways = np.arange(len(values))[:, np.newaxis]
    for _ in range(wanted - 1):
        reached = totals[:, np.newaxis] + steps
        for back, shown in enumerate(ways[:, : -LOOKBACK_PANELS - 1 : -1].T):
            reached -= prices[shown] / (1 + back / _SIMILAR_HALF_PANELS)
        last = reached.argmax(axis=0)
        totals = reached.max(axis=0) + values
        ways = np.hstack([ways[last], np.arange(len(values))[:, np.newaxis]])
    totals = totals - _UNEVEN_PACE_WEIGHT * (2 * wanted * (1 - places) - 1).clip(-2, 2) ** 2 / 4
    return [int(number) for number in ways[totals.argmax()]]


def _similarity_costs(like: np.ndarray) -> np.ndarray:
    """Return the cost of showing pictures next to each other, by their similarity: N x N."""
    nearly = ((like - DIFFERENT_SIMILARITY) / (SAME_SIMILARITY - DIFFERENT_SIMILARITY)).clip(0, 1)
    quite = ((like - SAME_SIMILARITY) / (1 - SAME_SIMILARITY)).clip(0, 1)
    return _SIMILAR_COST * nearly**2 + (_EQUAL_COST - _SIMILAR_COST) * quite**2


def _steps(pool: Sequence[Candidate], places: np.ndarray, wanted: int) -> np.ndarray:
    """Return the score of going from one candidate (row) to a later one (column); others are -infinity."""
    times = np.array([each.time for each in pool])
    scenes = np.array([each.scene for each in pool])
    gap = min(_MIN_PANEL_SECONDS, (times[-1] - times[0]) / (2 * wanted))
    pace = ((places[np.newaxis] - places[:, np.newaxis]) * wanted - 1).clip(-2, 2)
    scores = (
        -_TOO_CLOSE_COST * (times[np.newaxis] - times[:, np.newaxis] < gap)
        - _SAME_SCENE_COST * (scenes[np.newaxis] == scenes[:, np.newaxis])
        - _UNEVEN_PACE_WEIGHT * pace**2
    )
    return np.where(np.triu(np.ones(scores.shape, bool), 1), scores, -np.inf)


def scene_values(survey: Survey) -> np.ndarray:
    """Return the importance of each scene, 0..1, the most important one 1; high for long and rare scenes.

    L log(1/W), where L is the length of the scene and W the share of its group of scenes in the film
    (Uchihashi et al. 1999).
    """
    count = len(survey.scene_starts)
    ends = [*survey.scene_starts[1:], max(survey.seconds, survey.scene_starts[-1])]
    lengths = np.maximum(np.array(ends) - survey.scene_starts, 1e-3)
    kinds = _scene_groups(survey.candidates, count)
    shares = np.bincount(kinds, lengths, count)[kinds] / lengths.sum()
    values = lengths * np.log(1 / np.minimum(shares, 1))
    return values / values.max() if values.max() > 1e-6 else np.ones(count)


def _scene_groups(candidates: Sequence[Candidate], count: int) -> np.ndarray:
    """Return, for each scene, the index of the first scene that looks like it."""
    histograms = np.zeros((count, len(candidates[0].histogram)) if candidates else (count, 1), np.float32)
    for each in candidates:
        histograms[each.scene] += each.histogram
    histograms /= np.maximum(histograms.sum(axis=1, keepdims=True), 1e-6)
    kinds = np.arange(count)
    for scene in range(1, count):
        shared = np.minimum(histograms[:scene], histograms[scene]).sum(axis=1)
        if shared.max() > _MIN_GROUP_INTERSECTION:
            kinds[scene] = kinds[int(shared.argmax())]
    return kinds


def scores(pool: Sequence[Candidate], scenes: np.ndarray) -> np.ndarray:
    """Return the score of each frame, mostly 0..1.

    Args:
        pool: the frames.
        scenes: the value of each scene, 0..1.
    """
    sharp = np.array([each.sharpness for each in pool])
    clarity = np.array([each.clarity for each in pool])
    is_clear = clarity >= min(_MIN_CLARITY, float(clarity.max()))
    median = float(np.median(sharp[is_clear]))
    sharpest_by_scene = {
        scene: max(each.sharpness for each in pool if each.scene == scene)
        for scene in {each.scene for each in pool}
    }
    sharpest = np.array([sharpest_by_scene[each.scene] for each in pool])
    scene_rank = sharp / np.maximum(sharpest, 1e-6)
    wanted = np.minimum(_MIN_SHARPNESS_RATIO * median, np.maximum(sharpest, _MIN_SOFT_SCENE_RATIO * median))
    film_rank = sharp.argsort(kind="stable").argsort(kind="stable") / max(len(pool) - 1, 1)
    return (
        (_FILM_RANK_WEIGHT * film_rank + _SCENE_RANK_WEIGHT * scene_rank)
        * np.minimum(1, clarity / _MIN_CLARITY)
        + _CLARITY_WEIGHT * clarity
        + _FACE_WEIGHT * np.array([face_share(each) for each in pool])
        + _SCENE_WEIGHT * np.sqrt(scenes[[each.scene for each in pool]])
        - _MAX_MOTION_COST * np.minimum(1, [each.motion / _MAX_COST_MOTION for each in pool])
        + np.array([_action_value(each) for each in pool])
        - _MAX_BLUR_COST * (1 - sharp / np.maximum(wanted, 1e-6)).clip(0, 0.5) * 2
    )


def _action_value(candidate: Candidate) -> float:
    if candidate.action is None or candidate.faces:
        return _ACTION_SCORE / 2
    return _ACTION_SCORE * candidate.action.share - _MAX_CUT_SUBJECT_COST * candidate.action.cut


def face_share(candidate: Candidate) -> float:
    """Return the area of the largest face relative to a face in a close-up, 0..1."""
    if not candidate.faces:
        return 0.0
    height, width = candidate.shape
    return min(1.0, candidate.faces[0].area / (height * width) / _FULL_SCORE_FACE_SHARE)


def subject_strength(candidate: Candidate) -> float:
    """Return how clearly a frame shows a subject, 0..1: a face, a moving object, or a small salient area."""
    if candidate.faces:
        return _FACE_SUBJECT_SCORE + (1 - _FACE_SUBJECT_SCORE) * face_share(candidate)
    if candidate.action and not candidate.action.is_gone:
        return _ACTION_SUBJECT_SCORE * candidate.action.share * (1 - candidate.action.cut)
    height, width = candidate.shape
    compact = 1 - candidate.saliency.area / (_MAX_SUBJECT_AREA_SHARE * height * width)
    return _SALIENT_SUBJECT_SCORE * max(0.0, compact)


def importance(chosen: Sequence[Candidate], survey: Survey) -> list[float]:
    """Return the importance of each chosen frame, 0..1, the most important one 1.

    Subjects count most, so that people and what moves are shown large and places small. The value of a scene
    is divided among its frames. Requested frames are more important.
    """
    scenes = scene_values(survey)
    counts = np.bincount([each.scene for each in chosen], minlength=len(scenes))
    shown = [
        _SUBJECT_WEIGHT * subject_strength(each)
        + _SCENE_SHARE_WEIGHT * float(scenes[each.scene]) / counts[each.scene]
        + _QUALITY_WEIGHT * each.clarity * min(1.0, 2 * each.sharpness)
        + _FORCED_WEIGHT * each.forced
        for each in chosen
    ]
    most = max(shown, default=0.0)
    return [float(each / most) if most > 0 else 1.0 for each in shown]
