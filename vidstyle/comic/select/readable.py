"""The choice of frames that can be read once they are drawn."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.select.choose import choose
from vidstyle.comic.select.film_thirds import film_thirds
from vidstyle.comic.select.frame_scores import subject_strength
from vidstyle.comic.select.key_frame_options import KeyFrameOptions
from vidstyle.comic.select.refinement import Refinement
from vidstyle.comic.select.usable import usable_candidates
from vidstyle.errors import log

Selection = Callable[[Sequence[Candidate]], Sequence[Candidate]]
"""Returns some of the frames."""
Readability = Callable[[Sequence[Candidate]], Sequence[float]]
"""Returns how well frames can be read once they are drawn, 0..1."""
_MAX_ROUNDS = 3
"""Number of times that frames are chosen, without those that could not be read once they were drawn, and
without those that tell nothing new."""
_REFUSED_SECONDS = 1.2
"""Time around such a frame without another choice: darkness, blur and views last."""
_MIN_READABILITY, _MIN_PLACE_READABILITY = 0.55, 0.73
"""Minimum readability, see `measure_readability`; the second value is for a panel without a subject."""
_MIN_STORY_SCENES, _MIN_STORY_READABILITY = 4, 0.45
"""With readable frames of fewer scenes than the first value, or not of all thirds of the film, the best ones
of others are shown from the second value on: a page of a few pictures tells no story."""
_READABILITY_WEIGHT, _PLACE_READABILITY_WEIGHT = 1.0, 2.0
"""How much the importance of a frame depends on its readability; the second value is for a panel without a
subject, which tells nothing if it cannot be read."""
_MIN_SUBJECT_STRENGTH = 0.2
"""Strength of a subject from which it makes up for murk, see `subject_strength`."""


class ReadableSearch:
    """Chooses frames, and others for those that tell nothing new or cannot be read once they are drawn."""

    def __init__(
        self, refinement: Refinement, options: KeyFrameOptions, readability: Readability | None
    ) -> None:
        self._refinement, self._options = refinement, options
        self._measure: Readability = readability or (lambda candidates: [1.0] * len(candidates))
        self._known = dict[float, float]()

    def run(self, survey: Survey, forced: Sequence[Candidate], keep: Selection) -> list[Candidate]:
        """Return the frames to show, in the order of time; empty if the film has none.

        `keep`: returns the frames that tell something new; others are chosen instead of the rest.
        """
        found, lost, refused, options = list[Candidate](), list[Candidate](), list[Candidate](), self._options
        kept = list(forced)
        least = options.panels or max(options.min_panels, len(forced))
        usable = usable_candidates(survey.candidates)
        is_fixed = survey.is_folder or options.panels is not None
        for _ in range(_MAX_ROUNDS):
            left = [each for each in usable if not _is_near(each, refused)]
            chosen = choose(
                *(replace(survey, candidates=left), kept, options.panels),
                *(options.min_panels, options.spoken, options.seed),
            )
            if not chosen:
                break
            found = self._refinement.refine(chosen)
            self._known |= dict(zip((each.time for each in found), self._measure(found), strict=True))
            unreadable = [each for each in found if not self._is_readable(each)]
            readable = [each for each in found if self._is_readable(each)]
            told = {each.time for each in (readable if is_fixed or not readable else keep(readable))}
            surplus = [each for each in readable if each.time not in told]
            if survey.is_folder:
                return found
            if not (unreadable or surplus or len(found) < least):
                break
            lost += unreadable
            refused += unreadable + surplus
            bad = {each.time for each in refused}
            # `refine` returns its earlier results for these, without `forced`: they can still be pruned.
            kept = [
                replace(each, forced=True)
                for each, shown in zip(chosen, found, strict=True)
                if shown.time not in bad
            ]
        return self._keep_readable([*found, *lost], least, survey.seconds)

    def legibility_of(self, candidate: Candidate) -> float:
        """Return the factor on the importance of a chosen frame for its drawing: 0..1."""
        is_place = subject_strength(candidate) < _MIN_SUBJECT_STRENGTH
        weight = _PLACE_READABILITY_WEIGHT if is_place else _READABILITY_WEIGHT
        return max(0.0, 1 - weight * (1 - self._known[candidate.time]))

    def _is_readable(self, candidate: Candidate) -> bool:
        has_subject = subject_strength(candidate) >= _MIN_SUBJECT_STRENGTH
        limit = _MIN_READABILITY if has_subject else _MIN_PLACE_READABILITY
        return candidate.forced or self._known[candidate.time] >= limit

    def _keep_readable(self, candidates: Sequence[Candidate], least: int, seconds: float) -> list[Candidate]:
        """Return the readable frames, and the best of the others up to a number of frames, or for a story.

        A fixed number of panels has no more for a story.
        """
        distinct = {each.time: each for each in candidates}.values()
        kept = [each for each in distinct if self._is_readable(each)]
        others = sorted(
            (each for each in distinct if not self._is_readable(each)),
            key=lambda each: self._known[each.time],
            reverse=True,
        )
        if not kept and others:
            log.warning("no frame of the film can be drawn clearly; the best one is shown")
        if self._options.panels is None:
            kept += self._tell_more(kept, others, seconds)
        rest = [each for each in others if each not in kept]
        kept += rest[: max(0, max(1, least) - len(kept))]
        return sorted(kept, key=lambda each: each.time)

    def _tell_more(
        self, kept: Sequence[Candidate], others: Sequence[Candidate], seconds: float
    ) -> list[Candidate]:
        """Return frames that can nearly be read, of scenes or thirds of the film without a readable one."""
        told = list[Candidate]()
        good = [each for each in others if self._known[each.time] >= _MIN_STORY_READABILITY]
        thirds = set(film_thirds(kept, seconds))
        for each, third in zip(good, film_thirds(good, seconds), strict=True):
            if third not in thirds:
                thirds.add(third)
                told.append(each)
        scenes = {each.scene for each in (*kept, *told)}
        for each in good:
            if each.scene not in scenes and len(scenes) < _MIN_STORY_SCENES:
                scenes.add(each.scene)
                told.append(each)
        return told


def _is_near(candidate: Candidate, refused: Sequence[Candidate]) -> bool:
    return any(
        each.scene == candidate.scene and abs(each.time - candidate.time) < _REFUSED_SECONDS
        for each in refused
    )
