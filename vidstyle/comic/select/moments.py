"""The moments of a film that a comic page shows."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, replace

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.similarity import UNLIKE, similarity
from vidstyle.comic.analyze.survey import Film, Survey
from vidstyle.comic.moment import Moment
from vidstyle.comic.select.choose import BEFORE, choose
from vidstyle.comic.select.scoring import importance
from vidstyle.errors import InputError, UsageError

MAX_PANELS = 300


@dataclass(frozen=True)
class KeyFrameOptions:
    """What somebody wants of the choice.

    Attributes:
        panels: how many; None: as many as tell the film.
        least: where `panels` is None, so many rather than fewer, as far as the film has other pictures.
        at: seconds of pictures that are to be shown, as they are.
        skip: first and last second of parts of which nothing is to be shown.
    """

    panels: int | None = None
    at: tuple[float, ...] = ()
    skip: tuple[tuple[float, float], ...] = ()
    least: int = 0

    def check(self) -> None:
        """Raise UsageError where they make no sense, whatever the film."""
        if self.panels is not None and not 1 <= self.panels <= MAX_PANELS:
            raise UsageError(
                "panels", f"{self.panels} are none to lay out", f"give 1 to {MAX_PANELS}, or auto"
            )
        for first, last in self.skip:
            if not 0 <= first < last:
                raise UsageError("skip", f"{first:g}-{last:g} s is not a part of a film")
        for time in self.at:
            if time < 0:
                raise UsageError("at", f"{time:g} s lies before the film")
            if self.skips(time):
                raise UsageError("at", f"{time:g} s lies in a part that is to be skipped")

    def skips(self, time: float) -> bool:
        """Whether nothing is to be shown from this time."""
        return any(first <= time < last for first, last in self.skip)


def find_moments(film: Film, wishes: KeyFrameOptions | None = None) -> list[Moment]:
    """The moments that tell the film, in the order of time.

    There may be fewer than wanted where the film has not as many pictures.

    Raises:
        InputError: the film cannot be read, or nothing is to be seen in it.
        UsageError: the wishes make no sense, or not with this film.
    """
    wishes = wishes or KeyFrameOptions()
    wishes.check()
    survey = film.survey()
    forced = _forced(film, survey, wishes)
    left = [each for each in survey.candidates if not wishes.skips(each.time)]
    chosen = choose(replace(survey, candidates=left), forced, wishes.panels, wishes.least)
    if not chosen:
        if left:
            raise InputError(film.name, "nothing is to be seen in it: all its pictures are blank")
        raise UsageError("skip", "leaves nothing of the film")
    better = _better(film, chosen, wishes)
    return [
        Moment(each.time, each.shape, weight, each.salience, each.faces, each.scene, each.things, each.corner)
        for each, weight in zip(better, importance(better, survey), strict=True)
    ]


def _forced(film: Film, survey: Survey, wishes: KeyFrameOptions) -> list[Candidate]:
    last = max(survey.seconds, survey.candidates[-1].time)
    for time in wishes.at:
        if time > last + 1:
            raise UsageError("at", f"{time:g} s lies after the end", f"the film has {last:.1f} s")
    found = {}
    for time in wishes.at:
        each = film.at(time)
        scene = max(0, bisect_right(survey.begins, each.time) - 1)
        found[each.time] = replace(each, scene=scene, forced=True)
    return [found[time] for time in sorted(found)]


def _better(film: Film, chosen: Sequence[Candidate], wishes: KeyFrameOptions) -> list[Candidate]:
    """Each picture, or a better one close to it that looks like none of the others."""
    better = list(chosen)
    for number, each in enumerate(chosen):
        if each.forced:
            continue
        others = better[max(0, number - BEFORE) : number] + better[number + 1 : number + 1 + BEFORE]
        after = better[number - 1].time if number else -math.inf
        before = better[number + 1].time if number + 1 < len(better) else math.inf
        near = [
            other
            for other in film.around(each)
            if after < other.time < before and not (other.blank or other.mixed or wishes.skips(other.time))
        ]
        better[number] = _sharpest(_no_liker(near, each, others) or [each])
    return better


def _no_liker(near: Sequence[Candidate], each: Candidate, others: Sequence[Candidate]) -> list[Candidate]:
    """Those of the pictures near one that look no more like any of the others than that one."""
    if not others:
        return list(near)
    like = similarity([candidate.small for candidate in (each, *near, *others)])
    most = like[: -len(others), -len(others) :].max(axis=1)
    return [other for other, like in zip(near, most[1:], strict=True) if like <= max(UNLIKE, most[0])]


def _sharpest(near: Sequence[Candidate]) -> Candidate:
    """The sharpest and calmest, of faces the one that looks at us; of equal ones the first."""
    sharp, lit, eyes = (
        max((getattr(each, name) for each in near), default=0.0) or 1.0
        for name in ("sharpness", "clarity", "eyes")
    )
    faces = max(len(each.faces) for each in near)
    return max(
        near,
        key=lambda each: (
            each.sharpness / sharp
            + 0.8 * each.clarity / lit
            - 0.5 * min(1.0, each.motion)
            + (0.5 * each.eyes / eyes + 0.3 * len(each.faces) / faces if faces else 0)
        ),
    )
