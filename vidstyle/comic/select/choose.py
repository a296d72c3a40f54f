"""Choice of key frames: scores relative to the film, and the candidates with the best total."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.select.best_path import (
    FORCED_SCORE,
    film_places,
    find_best_path,
    pair_steps,
    similarity_costs,
)
from vidstyle.comic.select.film_thirds import film_thirds
from vidstyle.comic.select.frame_scores import scene_values, scores
from vidstyle.comic.select.likeness import MAX_STORY_SCENES, likeness
from vidstyle.comic.select.movers import shows_largest_mover
from vidstyle.comic.select.panel_count import DISTINCT_PANELS, MIN_DEFAULT_PANELS, count_panels, list_attempts
from vidstyle.comic.select.usable import keep_whole_subjects, usable_candidates

_MAX_POOL_CANDIDATES = 400
"""Maximum number of candidates considered, or twice the number of panels: the best of each part."""

_SPEAKER_SCORE = 0.4
"""Score of a frame with a face while someone speaks."""
_LARGEST_MOVER_SCORE = 1.0
"""Score of the largest mover of a film: what comes near for a moment is what the film is about."""
_SEED_SCORE = 0.6
"""Maximum that a seed adds to the score of a frame: less than speech with a face in a close-up."""
_MAX_SEED_PANELS = 1
"""Maximum number of panels that a seed adds to the default number, or takes from it."""


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
    seen = keep_whole_subjects(usable_candidates(survey.candidates))
    times = {each.time for each in forced}
    pool = sorted([*forced, *(each for each in seen if each.time not in times)], key=lambda each: each.time)
    if not pool:
        return []
    values = scores(pool, scene_values(survey)) + [FORCED_SCORE * each.forced for each in pool]
    values += [_SPEAKER_SCORE * bool(each.faces and _is_in_spans(each.time, spoken)) for each in pool]
    values += _LARGEST_MOVER_SCORE * shows_largest_mover(pool)
    random = np.random.default_rng(seed)
    values += _SEED_SCORE * random.random(len(pool)) if seed else 0.0
    kept = _keep_best_per_part(pool, values, survey, max(_MAX_POOL_CANDIDATES, 2 * (panels or 0)))
    pool, values = [pool[number] for number in kept], values[kept]
    scenes, places = len(survey.scene_starts), film_places(pool, survey)
    like = likeness(pool, scenes, sees_travel=scenes <= MAX_STORY_SCENES and not survey.is_folder)
    wanted = count_panels(survey, like, len(forced), panels, min_panels)
    if seed and panels is None and not survey.is_folder:
        varied = wanted + int(random.integers(-_MAX_SEED_PANELS, _MAX_SEED_PANELS, endpoint=True))
        wanted = min(len(pool), max(MIN_DEFAULT_PANELS, min_panels, len(forced), varied))
    thirds = None if survey.is_folder else np.array(film_thirds(pool, survey.seconds))
    tried = [(wanted, 1.0)] if panels is not None else list_attempts(survey, wanted, len(pool))
    chosen = list[int]()
    for count, limit in tried:
        if count < len(forced):
            break
        steps = pair_steps(pool, places, count)
        chosen = find_best_path(values, steps, similarity_costs(like), places, count, thirds)
        if not _has_repeats(like, chosen, limit):
            break
    return [pool[number] for number in chosen]


def _is_in_spans(time: float, spans: Sequence[tuple[float, float]]) -> bool:
    return any(start <= time <= end for start, end in spans)


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
