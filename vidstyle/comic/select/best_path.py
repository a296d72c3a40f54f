"""The best sequence of key frames by dynamic programming over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.analyze.similarity import DIFFERENT_SIMILARITY, SAME_SIMILARITY

# Costs of pairs of panels, relative to the scores of frames, which are 0..1.
FORCED_SCORE, _TOO_CLOSE_COST = 1000.0, 50.0
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
_SAME_SCENE_COST, _UNEVEN_PACE_WEIGHT = 0.2, 0.5
"""Cost of staying in a scene, and weight of an uneven pace."""
_MISSED_THIRD_COST = 4.0
"""Cost of a third of the film without a panel: beginning, middle and end make a story."""


def find_best_path(
    values: np.ndarray,
    steps: np.ndarray,
    prices: np.ndarray,
    places: np.ndarray,
    wanted: int,
    thirds: np.ndarray | None = None,
) -> list[int]:
    """Return the indices of the best `wanted` candidates, by dynamic programming over time.

    Maximizes the sum of values and steps minus the prices of pairs. As prices depend on several earlier
    choices, this is a beam search that keeps the best path to each candidate; its result is nearly optimal.

    Args:
        values: the score of each candidate.
        steps: the score of going from one candidate (row) to a later one (column).
        prices: the cost of two candidates as neighbours.
        places: see `film_places`.
        wanted: number of candidates to choose.
        thirds: the third of the film of each candidate, 0 to 2, if each third should be shown.
    """
    totals = values - _UNEVEN_PACE_WEIGHT * (2 * wanted * places - 1).clip(-2, 2) ** 2 / 4
    if thirds is not None:
        steps = steps - _MISSED_THIRD_COST * (np.subtract.outer(thirds, thirds) == -2)
        totals = totals - _MISSED_THIRD_COST * thirds
    ways = np.arange(len(values))[:, np.newaxis]
    for _ in range(wanted - 1):
        reached = totals[:, np.newaxis] + steps
        for back, shown in enumerate(ways[:, : -LOOKBACK_PANELS - 1 : -1].T):
            reached -= prices[shown] / (1 + back / _SIMILAR_HALF_PANELS)
        last = reached.argmax(axis=0)
        totals = reached.max(axis=0) + values
        ways = np.hstack([ways[last], np.arange(len(values))[:, np.newaxis]])
    totals = totals - _UNEVEN_PACE_WEIGHT * (2 * wanted * (1 - places) - 1).clip(-2, 2) ** 2 / 4
    if thirds is not None:
        totals = totals - _MISSED_THIRD_COST * (2 - thirds)
    return [int(number) for number in ways[totals.argmax()]]


def similarity_costs(like: np.ndarray) -> np.ndarray:
    """Return the cost of showing pictures next to each other, by their similarity: N x N."""
    nearly = ((like - DIFFERENT_SIMILARITY) / (SAME_SIMILARITY - DIFFERENT_SIMILARITY)).clip(0, 1)
    quite = ((like - SAME_SIMILARITY) / (1 - SAME_SIMILARITY)).clip(0, 1)
    return _SIMILAR_COST * nearly**2 + (_EQUAL_COST - _SIMILAR_COST) * quite**2


def pair_steps(pool: Sequence[Candidate], places: np.ndarray, wanted: int) -> np.ndarray:
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


def film_places(pool: Sequence[Candidate], survey: Survey) -> np.ndarray:
    """Return positions in the film, 0..1: the mean of time and scene, so that short scenes count too."""
    times = np.array([each.time for each in pool]) / max(survey.seconds, 1e-6)
    scenes = np.array([each.scene + 0.5 for each in pool]) / len(survey.scene_starts)
    return np.clip((times + (scenes if len(survey.scene_starts) > 1 else times)) / 2, 0, 1)
