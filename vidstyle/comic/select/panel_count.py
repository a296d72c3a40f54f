"""The number of panels of a film, by its scenes, its duration and what moves."""

from __future__ import annotations

import math

import numpy as np

from vidstyle.comic.analyze.features import Survey
from vidstyle.comic.analyze.similarity import SAME_SIMILARITY
from vidstyle.comic.select.likeness import MAX_STORY_SCENES

MIN_DEFAULT_PANELS, MAX_DEFAULT_PANELS = 1, 40
"""Range of the default number of panels."""
DISTINCT_PANELS = 9
"""If the number of panels is free, no two of this many successive panels look nearly the same: a page."""
_MIN_MOVING_PANELS = 3
"""With fewer panels, a film with motion is shown by frames at regular intervals, though they look alike."""
_BEAT_SECONDS, _MAX_BEAT_PANELS, _MIN_BEAT_PANELS = 0.9, 3, 2
"""Interval of these frames, and their maximum and minimum number: a wide view and a close-up."""
_MOMENT_SIMILARITY, _BEAT_SIMILARITY = 0.62, 0.8
"""Maximum similarity of moments in front of a still camera, and of beats beyond their minimum number."""
_MIN_FILM_MOTION = 0.02
"""Motion above which a film is not still."""

_MAX_STORY_PANELS, _MIN_STORY_SECONDS = 6, 1.4
"""Panels that a film of up to `MAX_STORY_SCENES` scenes gets for its moments, each for at least this
duration."""


def default_panels(scenes: int, seconds: float) -> int:
    """Return the default number of panels of a film; it grows with scenes and duration, ever more slowly.

    >>> default_panels(1, 5), default_panels(26, 70), default_panels(1500, 7200)
    (3, 12, 40)
    """
    return min(
        MAX_DEFAULT_PANELS,
        max(MIN_DEFAULT_PANELS, round(1.5 * math.sqrt(scenes) + math.log2(1 + seconds / 4))),
    )


def count_panels(survey: Survey, like: np.ndarray, forced: int, panels: int | None, min_panels: int) -> int:
    """Return the number of panels wanted: as requested, or of different pictures.

    Args:
        survey: of the film.
        like: similarity of the candidates, N x N.
        forced: number of requested frames.
        panels, min_panels: see `choose`.
    """
    if panels is not None:
        return min(len(like), max(forced, panels))
    distinct: list[int] = []
    for number in range(len(like)):
        if not (like[number, distinct[-DISTINCT_PANELS:]] > SAME_SIMILARITY).any():
            distinct.append(number)
    scenes = len(survey.scene_starts)
    usual = MAX_DEFAULT_PANELS if survey.is_folder else default_panels(scenes, survey.seconds)
    if scenes <= MAX_STORY_SCENES:
        usual = max(usual, min(_MAX_STORY_PANELS, int(survey.seconds / _MIN_STORY_SECONDS)))
    return max(forced, min(max(usual, min_panels), MAX_DEFAULT_PANELS, len(distinct)))


def list_attempts(survey: Survey, wanted: int, most: int) -> list[tuple[int, float]]:
    """Return numbers of panels to try, each with the similarity that no two of them may exceed.

    Args:
        survey: of the film.
        wanted: number of panels with different pictures.
        most: number of candidates.
    """
    beats, usual = _count_beats(survey, most), min(most, default_panels(1, survey.seconds))
    if beats == 1:
        return [(count, SAME_SIMILARITY) for count in range(wanted, 0, -1)]
    several = [(count, SAME_SIMILARITY) for count in range(wanted, _MIN_MOVING_PANELS - 1, -1)]
    moments = [(count, _MOMENT_SIMILARITY) for count in range(usual, _MIN_MOVING_PANELS, -1)]
    return several + moments + [(count, _BEAT_SIMILARITY) for count in range(beats, _MIN_BEAT_PANELS - 1, -1)]


def _count_beats(survey: Survey, most: int) -> int:
    """Return the number of panels of a film with few different pictures: 1 if nothing moves."""
    moves = not survey.is_folder and any(each.motion > _MIN_FILM_MOTION for each in survey.candidates)
    return max(1, min(_MAX_BEAT_PANELS, most, round(survey.seconds / _BEAT_SECONDS))) if moves else 1
