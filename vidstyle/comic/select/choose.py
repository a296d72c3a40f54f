"""Choose key frames: scores relative to the film, and the candidates with the best total."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from vidstyle.comic.analyze.action import unlike
from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.analyze.similarity import DIFFERENT, SIMILAR, similarity

MIN_PANELS, MAX_PANELS = 1, 40
"""Range of the number of panels."""
MAX_CANDIDATES = 400
"""Maximum number of candidates considered, or twice that of panels: the best of each part of the film."""
LOOKBACK = 12
"""Number of preceding panels that each one is compared with: two pages."""
PANELS_PER_PAGE = 6
"""If the number of panels is free, no two of so many successive ones look nearly the same."""

FEW = 3
"""With fewer panels a film that moves is told by moments of its shots, however alike they look."""
BEAT, _BEATS = 0.9, 5
"""Seconds of film for each such moment, and their maximum number."""
_MOVES = 0.02
"""Motion above which something happens in a film."""

_FORCED, _TOO_CLOSE = 1000.0, 50.0
"""Score of a requested frame, and cost of two frames too close together in time. Each outweighs the sum of
all terms after it."""
_SIMILAR, _SAME = 2.0, 20.0
"""Costs of two neighbours that look nearly the same, and of two equal ones. Scores are 0..1, so that this
happens only if there are no other frames."""
_FADES = 3
"""Distance in panels at which that cost is half as high."""
_SAME_SCENE, _PACE = 0.2, 0.25
"""Cost of staying in a scene, and weight of an uneven pace."""
_MIN_GAP = 0.4
"""Minimum seconds between two panels."""

_KIN = 0.65
"""Scenes with a higher histogram intersection form a group, such as the shots of a speaker in a dialogue."""
_MIXED, _BLURRED, _SOFT, _SOFTEST = 1.0, 0.5, 0.8, 0.4
"""Cost of a blend of two shots; maximum cost of blur; the share of the median sharpness below which a frame
is blurred (close-ups of faces have few edges), and that share in a scene that is soft throughout."""
_EMPTY = 0.35
"""Clarity below which sharpness counts less, as there is little to see."""
_MOVING, _WILD = 0.5, 0.6
"""Maximum cost of motion, and the motion from which it applies: motion blur beyond what edges show."""
_SPEAKER = 0.4
"""Score of a frame with a face while somebody speaks."""
_ACTION, _CUT_OFF = 0.3, 0.3
"""Score of a subject that moves, and maximum cost of one that the picture's edge cuts off."""
_ELSEWHERE = 0.5
"""How much less alike two frames are whose subject is elsewhere."""
_LARGE_FACE = 0.12
"""A face that covers this share of the picture scores as high as any larger one."""


def default_panels(scenes: int, seconds: float) -> int:
    """The default number of panels of a film: it grows with scenes and duration, ever more slowly.

    >>> default_panels(1, 5), default_panels(26, 70), default_panels(1500, 7200)
    (3, 12, 40)
    """
    return min(MAX_PANELS, max(MIN_PANELS, round(1.5 * math.sqrt(scenes) + math.log2(1 + seconds / 4))))


def choose(
    survey: Survey,
    forced: Sequence[Candidate],
    panels: int | None,
    least: int = 0,
    spoken: Sequence[tuple[float, float]] = (),
) -> list[Candidate]:
    """The frames to show, in chronological order.

    Args:
        survey: the candidates; blank ones are left out, and if there are others damaged ones and those from
            which the subject of their shot is gone.
        forced: requested frames, which are always chosen.
        panels: how many in all; None: `default_panels`, fewer where pictures would look the same, but of a
            film that moves at least a few.
        least: minimum number where `panels` is None.
        spoken: start and end of what is said, in seconds: then faces are wanted.
    """
    clear = [each for each in survey.candidates if not each.blank]
    seen = [each for each in clear if not each.damaged] or clear
    seen = [each for each in seen if not (each.action and each.action.is_gone)] or seen
    times = {each.time for each in forced}
    pool = sorted([*forced, *(each for each in seen if each.time not in times)], key=lambda each: each.time)
    if not pool:
        return []
    values = scores(pool, scene_values(survey)) + [_FORCED * each.forced for each in pool]
    values += [_SPEAKER * bool(each.faces and _is_within(each.time, spoken)) for each in pool]
    kept = _thinned(pool, values, survey, max(MAX_CANDIDATES, 2 * (panels or 0)))
    pool, values = [pool[number] for number in kept], values[kept]
    like, places = _likeness(pool), _places(pool, survey)
    wanted, beats = _wanted(survey, like, len(forced), panels, least), _beats(survey, len(pool))
    while True:
        few = wanted < FEW and panels is None
        wanted = max(wanted, beats) if few else wanted
        chosen = _best(values, _steps(pool, places, wanted), _similarity_costs(like), places, wanted)
        if few or panels is not None or wanted <= max(1, len(forced)) or not _has_doubles(like, chosen):
            return [pool[number] for number in chosen]
        wanted -= 1


def _is_within(time: float, spans: Sequence[tuple[float, float]]) -> bool:
    return any(start <= time <= end for start, end in spans)


def _likeness(pool: Sequence[Candidate]) -> np.ndarray:
    """Similarity of frames, N x N; less of those before a still camera whose subject is elsewhere."""
    like = similarity([each.thumbnail for each in pool])
    for first, one in enumerate(pool):
        for second, other in enumerate(pool[:first]):
            if one.action and other.action and one.scene == other.scene:
                like[[first, second], [second, first]] -= _ELSEWHERE * unlike(one.action, other.action)
    return like


def _beats(survey: Survey, most: int) -> int:
    """How many moments tell a film of which few pictures differ: 1 where nothing moves."""
    moves = not survey.is_folder and any(each.motion > _MOVES for each in survey.candidates)
    return max(1, min(_BEATS, most, round(survey.seconds / BEAT))) if moves else 1


def _wanted(survey: Survey, like: np.ndarray, forced: int, panels: int | None, least: int) -> int:
    if panels is not None:
        return min(len(like), max(forced, panels))
    distinct: list[int] = []
    for number in range(len(like)):
        if not (like[number, distinct[-PANELS_PER_PAGE:]] > SIMILAR).any():
            distinct.append(number)
    usual = MAX_PANELS if survey.is_folder else default_panels(len(survey.scene_starts), survey.seconds)
    return max(forced, min(max(usual, least), MAX_PANELS, len(distinct)))


def _has_doubles(like: np.ndarray, chosen: Sequence[int]) -> bool:
    """Whether two frames within `PANELS_PER_PAGE` successive panels look nearly the same."""
    near = np.tri(len(chosen), k=PANELS_PER_PAGE - 1, dtype=bool) & ~np.tri(len(chosen), dtype=bool)
    return bool((like[np.ix_(chosen, chosen)] > SIMILAR)[near].any())


def _places(pool: Sequence[Candidate], survey: Survey) -> np.ndarray:
    """Position in the film, 0..1: the mean of those by time and by scene, so that short scenes count, too."""
    times = np.array([each.time for each in pool]) / max(survey.seconds, 1e-6)
    scenes = np.array([each.scene + 0.5 for each in pool]) / len(survey.scene_starts)
    return np.clip((times + (scenes if len(survey.scene_starts) > 1 else times)) / 2, 0, 1)


def _thinned(pool: Sequence[Candidate], values: np.ndarray, survey: Survey, most: int) -> np.ndarray:
    """The indices of the candidates considered: the best of each part of the film."""
    parts = np.minimum((_places(pool, survey) * most / 2).astype(int), most // 2 - 1)
    kept: dict[int, list[int]] = {}
    for number in np.argsort(-values, kind="stable"):
        part = kept.setdefault(int(parts[number]), [])
        if len(part) < 2 or pool[number].forced:
            part.append(int(number))
    return np.array(sorted(number for part in kept.values() for number in part))


def _best(
    values: np.ndarray, steps: np.ndarray, prices: np.ndarray, places: np.ndarray, wanted: int
) -> list[int]:
    """The indices of the best `wanted` candidates, by dynamic programming over time.

    Maximizes the sum of values and steps less the prices of pairs. As prices depend on several earlier
    choices, this is a beam search that keeps the best path to each candidate, which is nearly optimal.

    Args:
        values: the score of each candidate.
        steps: the score of going from one candidate (row) to a later one (column).
        prices: the cost of two candidates as neighbours.
        places: see `_places`.
        wanted: how many.
    """
    totals = values - _PACE * (2 * wanted * places - 1).clip(-2, 2) ** 2 / 4
    ways = np.arange(len(values))[:, np.newaxis]
    for _ in range(wanted - 1):
        reached = totals[:, np.newaxis] + steps
        for back, shown in enumerate(ways[:, : -LOOKBACK - 1 : -1].T):
            reached -= prices[shown] / (1 + back / _FADES)
        last = reached.argmax(axis=0)
        totals = reached.max(axis=0) + values
        ways = np.hstack([ways[last], np.arange(len(values))[:, np.newaxis]])
    totals = totals - _PACE * (2 * wanted * (1 - places) - 1).clip(-2, 2) ** 2 / 4
    return [int(number) for number in ways[totals.argmax()]]


def _similarity_costs(like: np.ndarray) -> np.ndarray:
    """The cost of showing pictures next to each other, by their similarity: N x N."""
    nearly = ((like - DIFFERENT) / (SIMILAR - DIFFERENT)).clip(0, 1)
    quite = ((like - SIMILAR) / (1 - SIMILAR)).clip(0, 1)
    return _SIMILAR * nearly**2 + (_SAME - _SIMILAR) * quite**2


def _steps(pool: Sequence[Candidate], places: np.ndarray, wanted: int) -> np.ndarray:
    """The score of going from one candidate (row) to a later one (column); minus infinity to others."""
    times = np.array([each.time for each in pool])
    scenes = np.array([each.scene for each in pool])
    gap = min(_MIN_GAP, (times[-1] - times[0]) / (2 * wanted))
    pace = ((places[np.newaxis] - places[:, np.newaxis]) * wanted - 1).clip(-2, 2)
    scores = (
        -_TOO_CLOSE * (times[np.newaxis] - times[:, np.newaxis] < gap)
        - _SAME_SCENE * (scenes[np.newaxis] == scenes[:, np.newaxis])
        - _PACE * pace**2
    )
    return np.where(np.triu(np.ones(scores.shape, bool), 1), scores, -np.inf)


def scene_values(survey: Survey) -> np.ndarray:
    """The importance of each scene, 0..1, the most important one 1; high for long and rare scenes.

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
    """For each scene, the index of the first scene that looks like it."""
    histograms = np.zeros((count, len(candidates[0].histogram)) if candidates else (count, 1), np.float32)
    for each in candidates:
        histograms[each.scene] += each.histogram
    histograms /= np.maximum(histograms.sum(axis=1, keepdims=True), 1e-6)
    kinds = np.arange(count)
    for scene in range(1, count):
        shared = np.minimum(histograms[:scene], histograms[scene]).sum(axis=1)
        if shared.max() > _KIN:
            kinds[scene] = kinds[int(shared.argmax())]
    return kinds


def scores(pool: Sequence[Candidate], scenes: np.ndarray) -> np.ndarray:
    """The score of each frame, mostly 0..1.

    Args:
        scenes: the value of each scene, 0..1.
    """
    sharp = np.array([each.sharpness for each in pool])
    clarity = np.array([each.clarity for each in pool])
    shown = clarity >= min(_EMPTY, float(clarity.max()))
    usual = float(np.median(sharp[shown]))
    best = {
        scene: max(each.sharpness for each in pool if each.scene == scene)
        for scene in {each.scene for each in pool}
    }
    sharpest = np.array([best[each.scene] for each in pool])
    beside = sharp / np.maximum(sharpest, 1e-6)
    wanted = np.minimum(_SOFT * usual, np.maximum(sharpest, _SOFTEST * usual))
    rank = sharp.argsort(kind="stable").argsort(kind="stable") / max(len(pool) - 1, 1)
    return (
        (0.15 * rank + 0.25 * beside) * np.minimum(1, clarity / _EMPTY)
        + 0.6 * clarity
        + 0.25 * np.array([face_share(each) for each in pool])
        + 0.3 * np.sqrt(scenes[[each.scene for each in pool]])
        - _MOVING * np.minimum(1, [each.motion / _WILD for each in pool])
        + np.array([_action_value(each) for each in pool])
        - _MIXED * np.array([each.in_transition for each in pool])
        - _BLURRED * (1 - sharp / np.maximum(wanted, 1e-6)).clip(0, 0.5) * 2
    )


def _action_value(candidate: Candidate) -> float:
    if candidate.action is None or candidate.faces:
        return _ACTION / 2
    return _ACTION * candidate.action.share - _CUT_OFF * candidate.action.cut


def face_share(candidate: Candidate) -> float:
    """The area of the largest face relative to that in a close-up, 0..1."""
    if not candidate.faces:
        return 0.0
    height, width = candidate.shape
    return min(1.0, candidate.faces[0].area / (height * width) / _LARGE_FACE)


def importance(chosen: Sequence[Candidate], survey: Survey) -> list[float]:
    """The importance of each chosen frame, 0..1, the most important one 1.

    A scene's value is divided among its frames; the rest depends on what they show. Requested frames are
    more important.
    """
    scenes = scene_values(survey)
    counts = np.bincount([each.scene for each in chosen], minlength=len(scenes))
    shown = [
        0.5 * float(scenes[each.scene]) / counts[each.scene]
        + 0.25 * each.clarity * min(1.0, 2 * each.sharpness)
        + 0.25 * face_share(each)
        + 0.25 * each.forced
        + 0.5 * _action_value(each)
        for each in chosen
    ]
    most = max(shown, default=0.0)
    return [float(each / most) if most > 0 else 1.0 for each in shown]
