"""Select the key frames of a film."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from vidstyle.comic.analyze.action import with_actions
from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.analyze.film import Film
from vidstyle.comic.analyze.similarity import DIFFERENT, similarity
from vidstyle.comic.moment import Moment
from vidstyle.comic.select.choose import LOOKBACK, choose, importance
from vidstyle.comic.select.framing import framed, with_details, without_repeats
from vidstyle.errors import InputError, UsageError
from vidstyle.pipeline.progress import OnStep, unwatched

MAX_PANELS = 300
_LOOKED = 3
"""Frames beside a chosen one in which faces are looked for, the best by all else."""


@dataclass(frozen=True)
class KeyFrameOptions:
    """How key frames are chosen.

    Attributes:
        panels: how many; None: a default that depends on the film.
        min_panels: where `panels` is None, at least so many, if the film has enough different pictures.
        spoken: start and end in seconds of what is said by somebody who may be seen.
        at: times in seconds of frames that must be shown.
        skip: start and end in seconds of parts to leave out.
    """

    panels: int | None = None
    at: tuple[float, ...] = ()
    skip: tuple[tuple[float, float], ...] = ()
    min_panels: int = 0
    spoken: tuple[tuple[float, float], ...] = ()

    def check(self) -> None:
        """Raise UsageError if they contradict each other, whatever the film."""
        if self.panels is not None and not 1 <= self.panels <= MAX_PANELS:
            raise UsageError("--panels", f"{self.panels} is outside 1 to {MAX_PANELS}")
        for first, last in self.skip:
            if not 0 <= first < last:
                raise UsageError("--skip", f"{first:g}-{last:g} s is not a part of a film")
        for time in self.at:
            if time < 0:
                raise UsageError("--at", f"{time:g} s lies before the film")
            if self.skips(time):
                raise UsageError("--at", f"{time:g} s lies in a part that is to be skipped")

    def skips(self, time: float) -> bool:
        """Whether a time lies in a skipped part."""
        return any(first <= time < last for first, last in self.skip)


def find_moments(
    film: Film, options: KeyFrameOptions | None = None, on_step: OnStep = unwatched
) -> list[Moment]:
    """The key frames of a film, in chronological order.

    There are fewer than requested if the film has not as many frames.

    Raises:
        InputError: the film cannot be read, or nothing is to be seen in it.
        UsageError: the options contradict each other or the film.
    """
    options = options or KeyFrameOptions()
    options.check()
    survey = film.survey(on_step)
    forced = _forced(film, survey, options)
    left = [each for each in survey.candidates if not options.skips(each.time)]
    seen = replace(survey, candidates=left)
    chosen = choose(seen, forced, options.panels, options.min_panels, options.spoken)
    if not chosen:
        if left:
            raise InputError(film.name, "nothing is to be seen in it: all its pictures are blank")
        raise UsageError("--skip", "leaves nothing of the film")
    better = _better(film, chosen, survey, options, on_step)
    weights = importance(better, survey)
    weighted = [replace(each, importance=weight) for each, weight in zip(better, weights, strict=True)]
    if survey.is_folder:
        return list(weighted)
    if options.panels is not None or options.min_panels:
        return list(framed(weighted))
    told = without_repeats(framed(weighted))
    return list(with_details(told) if len(survey.candidates) > 1 else told)


def _forced(film: Film, survey: Survey, options: KeyFrameOptions) -> list[Candidate]:
    last = max(survey.seconds, survey.candidates[-1].time)
    for time in options.at:
        if time > last + 1:
            raise UsageError("--at", f"{time:g} s lies after the end", f"the film has {last:.1f} s")
    found = {}
    for time in options.at:
        each = film.at(time)
        scene = max(0, bisect_right(survey.scene_starts, each.time) - 1)
        found[each.time] = replace(each, scene=scene, forced=True)
    return [found[time] for time in sorted(found)]


def _better(
    film: Film, chosen: Sequence[Candidate], survey: Survey, options: KeyFrameOptions, on_step: OnStep
) -> list[Candidate]:
    """Each frame, or a better one close to it that is no more similar to the others."""
    better, beside = list(chosen), [list[Candidate]() for _ in chosen]
    for number, each in enumerate(chosen):
        on_step("choosing key frames", number, len(chosen))
        if each.forced:
            continue
        others = better[max(0, number - LOOKBACK) : number] + better[number + 1 : number + 1 + LOOKBACK]
        after = better[number - 1].time if number else -math.inf
        before = better[number + 1].time if number + 1 < len(better) else math.inf
        near = [
            other
            for other in film.around(each)
            if after < other.time < before
            and not (other.blank or other.in_transition or other.damaged or options.skips(other.time))
        ]
        near = _not_more_similar(near, each, others) or [replace(film.at(each.time), scene=each.scene)]
        near = with_actions(near, [other for other in survey.candidates if other.scene == each.scene])
        likely = sorted(near, key=_worth(near), reverse=True)[:_LOOKED]
        seen = film.with_large_faces(likely)
        better[number] = max(seen, key=_worth(seen))
        beside[number] = [other for other in seen if other is not better[number]]
    return film.with_subjects(better, beside)


def _not_more_similar(
    near: Sequence[Candidate], each: Candidate, others: Sequence[Candidate]
) -> list[Candidate]:
    """The frames near one that are no more similar to any of the others than that one."""
    if not others:
        return list(near)
    like = similarity([candidate.thumbnail for candidate in (each, *near, *others)])
    most = like[: -len(others), -len(others) :].max(axis=1)
    return [other for other, like in zip(near, most[1:], strict=True) if like <= max(DIFFERENT, most[0])]


def _worth(near: Sequence[Candidate]) -> Callable[[Candidate], float]:
    """The sum of sharpness, exposure, stillness, action, faces and open eyes of a frame beside others."""
    sharp, lit, eyes = (
        max((getattr(each, name) for each in near), default=0.0) or 1.0
        for name in ("sharpness", "clarity", "eyes")
    )
    faces = max(len(each.faces) for each in near)
    return lambda each: (
        each.sharpness / sharp
        + 0.8 * each.clarity / lit
        - 0.5 * min(1.0, each.motion)
        + (0.5 * (each.action.share - each.action.cut) if each.action and not each.faces else 0)
        + (0.5 * each.eyes / eyes + 0.3 * len(each.faces) / faces if faces else 0)
    )
