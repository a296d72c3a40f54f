"""Chooses among the pictures of a film those that tell it: the best of all choices in the order of time."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence

import numpy as np

from vidstyle.comic.judge import Candidate, hash_distances, look_alike
from vidstyle.comic.survey import Survey
from vidstyle.comic.worth import scene_values, scores

FEWEST, MOST = 1, 40
"""Panels that are chosen where nothing is said."""
CONSIDERED = 600
"""Candidates that the choice is made among; the better ones of each part of the film."""

_FORCED, _TOO_CLOSE, _SAME = 1000.0, 50.0, 20.0
"""What it is worth to keep a picture that was asked for, and what it costs to show two too close together in
time, or two that look the same. Each outweighs whatever the later ones can add up to."""
_NOVELTY, _SAME_SCENE, _PACE = 0.3, 0.2, 0.25
"""What a new look, another scene and an even pace are worth, beside scores of 0..1."""
_LEAST_GAP = 0.4
"""Seconds between two panels."""


def usual_panels(scenes: int, seconds: float) -> int:
    """How many panels tell a film: the more scenes and the longer, the more, but ever more slowly.

    >>> usual_panels(1, 5), usual_panels(26, 70), usual_panels(1500, 7200)
    (3, 12, 40)
    """
    return min(MOST, max(FEWEST, round(1.5 * math.sqrt(scenes) + math.log2(1 + seconds / 4))))


def choose(survey: Survey, forced: Sequence[Candidate], panels: int | None) -> list[Candidate]:
    """The pictures to show, in the order of time.

    Args:
        survey: what there is; blank pictures are left out.
        forced: pictures that are shown whatever they are.
        panels: how many in all; None: `usual_panels`, and fewer where pictures would look the same.
    """
    seen = [each for each in survey.candidates if not each.blank]
    times = {each.time for each in forced}
    pool = sorted([*forced, *(each for each in seen if each.time not in times)], key=lambda each: each.time)
    if not pool:
        return []
    values = scores(pool, scene_values(survey)) + [_FORCED * each.forced for each in pool]
    kept = _thinned(pool, values, survey)
    pool, values = [pool[number] for number in kept], values[kept]
    return _without_doubles(pool, values, survey, _wanted(survey, pool, len(forced), panels))


def _wanted(survey: Survey, pool: Sequence[Candidate], forced: int, panels: int | None) -> int:
    if panels is not None:
        return min(len(pool), max(forced, panels))
    alike = look_alike(pool)
    distinct: list[int] = []
    for number in range(len(pool)):
        if not alike[number, distinct].any():
            distinct.append(number)
    usual = MOST if survey.pictures else usual_panels(len(survey.begins), survey.seconds)
    return max(forced, min(usual, len(distinct)))


def _places(pool: Sequence[Candidate], survey: Survey) -> np.ndarray:
    """Where in the film each lies, 0..1: half by time and half by scenes, so that short ones count too."""
    times = np.array([each.time for each in pool]) / max(survey.seconds, 1e-6)
    scenes = np.array([each.scene + 0.5 for each in pool]) / len(survey.begins)
    return np.clip((times + (scenes if len(survey.begins) > 1 else times)) / 2, 0, 1)


def _thinned(pool: Sequence[Candidate], values: np.ndarray, survey: Survey) -> np.ndarray:
    """The numbers of those that are considered: of each part of the film the best."""
    parts = np.minimum((_places(pool, survey) * CONSIDERED / 2).astype(int), CONSIDERED // 2 - 1)
    kept: dict[int, list[int]] = {}
    for number in np.argsort(-values, kind="stable"):
        part = kept.setdefault(int(parts[number]), [])
        if len(part) < 2 or pool[number].forced:
            part.append(int(number))
    return np.array(sorted(number for part in kept.values() for number in part))


def _without_doubles(
    pool: list[Candidate], values: np.ndarray, survey: Survey, wanted: int
) -> list[Candidate]:
    """The best choice in which no two look the same, as long as there are enough others.

    Neighbours that look alike cost; of others that do, the better one is kept, all that look like it are
    taken out, and the choice is made again.
    """
    alike = look_alike(pool)
    left = np.arange(len(pool))
    while True:
        considered = [pool[number] for number in left]
        chosen = left[_best(considered, values[left], _places(considered, survey), wanted)]
        doubles = np.intersect1d(left, _doubles(pool, values, alike, chosen))
        if len(doubles) == 0 or len(left) == wanted:
            return [pool[int(number)] for number in chosen]
        worst = doubles[np.argsort(values[doubles], kind="stable")][: len(left) - wanted]
        left = np.setdiff1d(left, worst)


def _doubles(
    pool: Sequence[Candidate], values: np.ndarray, alike: np.ndarray, chosen: np.ndarray
) -> list[int]:
    """Those that look like the better one of two chosen that look the same."""
    best = sorted((int(number) for number in chosen), key=lambda number: -values[number])
    for one, other in itertools.combinations(best, 2):
        if alike[one, other] and not pool[other].forced:
            return [
                int(number)
                for number in np.flatnonzero(alike[one])
                if number != one and not pool[int(number)].forced
            ]
    return []


def _best(pool: Sequence[Candidate], values: np.ndarray, places: np.ndarray, wanted: int) -> list[int]:
    """The numbers of the best choice of `wanted` candidates, by dynamic programming over time.

    It has the largest sum of values, and of what each picture is worth behind the one before it.
    """
    steps = _steps(pool, places, wanted)
    totals = values - _PACE * (2 * wanted * places - 1).clip(-2, 2) ** 2 / 4
    before: list[np.ndarray] = []
    for _ in range(wanted - 1):
        reached = totals[:, np.newaxis] + steps
        before.append(reached.argmax(axis=0))
        totals = reached.max(axis=0) + values
    totals = totals - _PACE * (2 * wanted * (1 - places) - 1).clip(-2, 2) ** 2 / 4
    chosen = [int(totals.argmax())]
    for previous in reversed(before):
        chosen.append(int(previous[chosen[-1]]))
    return chosen[::-1]


def _steps(pool: Sequence[Candidate], places: np.ndarray, wanted: int) -> np.ndarray:
    """What it is worth to go from one candidate (row) to a later one (column); minus infinity to others."""
    times = np.array([each.time for each in pool])
    scenes = np.array([each.scene for each in pool])
    gap = min(_LEAST_GAP, (times[-1] - times[0]) / (2 * wanted))
    pace = ((places[np.newaxis] - places[:, np.newaxis]) * wanted - 1).clip(-2, 2)
    worth = (
        _NOVELTY * np.minimum(hash_distances(pool), 32) / 32
        - _SAME * look_alike(pool)
        - _TOO_CLOSE * (times[np.newaxis] - times[:, np.newaxis] < gap)
        - _SAME_SCENE * (scenes[np.newaxis] == scenes[:, np.newaxis])
        - _PACE * pace**2
    )
    return np.where(np.triu(np.ones(worth.shape, bool), 1), worth, -np.inf)
