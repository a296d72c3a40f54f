"""Selection of the key frames of a film."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from vidstyle.comic.analyze.action import add_actions
from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.analyze.key_frame_source import Film
from vidstyle.comic.analyze.motion_blur import MAX_PICTURE_FLOW, subject_flow
from vidstyle.comic.analyze.similarity import DIFFERENT_SIMILARITY, similarity
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.select.best_path import LOOKBACK_PANELS
from vidstyle.comic.select.choose import (
    MAX_DEFAULT_PANELS,
    choose,
    usable_candidates,
)
from vidstyle.comic.select.frame_scores import importance
from vidstyle.comic.select.framing import alternate_framing, merge_equal, remove_repeats
from vidstyle.comic.select.prune import prune
from vidstyle.errors import InputError, UsageError
from vidstyle.pipeline.progress import ProgressCallback, ignore_progress

_CUT_FACTOR = 2.0
"""How much more it counts that a subject is cut off than that it is large."""
MAX_PANELS = 300
"""Maximum number of panels that can be requested."""
_MAX_FACE_CANDIDATES = 3
"""Number of frames near a chosen one in which faces are detected: the best by all other features."""
_CLARITY_WEIGHT, _MOTION_WEIGHT, _FLOW_WEIGHT = 0.8, 0.5, 0.5
_ACTION_WEIGHT, _EYES_WEIGHT, _FACES_WEIGHT = 0.5, 0.5, 0.3
"""Weights of the features by which frames of one shot are compared, relative to sharpness."""


@dataclass(frozen=True)
class KeyFrameOptions:
    """How key frames are chosen.

    Attributes:
        panels: number of panels; None: a default that depends on the film.
        min_panels: minimum number if `panels` is None and the film has enough different pictures.
        spoken: start and end in seconds of speech by people who may be visible.
        at: times in seconds of frames that must be shown.
        skip: start and end in seconds of parts to exclude.
        words: times in seconds of words that need a panel nearby, if `panels` is None.
        seed: random seed of a choice that is nearly as good as the best one, which 0 gives.
    """

    panels: int | None = None
    at: tuple[float, ...] = ()
    skip: tuple[tuple[float, float], ...] = ()
    min_panels: int = 0
    spoken: tuple[tuple[float, float], ...] = ()
    words: tuple[float, ...] = ()
    seed: int = 0

    def check(self) -> None:
        """Raise UsageError if they contradict each other; needs no film."""
        if self.panels is not None and not 1 <= self.panels <= MAX_PANELS:
            raise UsageError("--panels", f"{self.panels} is outside 1 to {MAX_PANELS}")
        for first, last in self.skip:
            if not 0 <= first < last:
                raise UsageError("--skip", f"{first:g}-{last:g} s is not a valid range")
        for time in self.at:
            if time < 0:
                raise UsageError("--at", f"{time:g} s is before the start of the film")
            if self.skips(time):
                raise UsageError("--at", f"{time:g} s is in a part that --skip excludes")

    def skips(self, time: float) -> bool:
        """Whether a time is in a skipped part."""
        return any(first <= time < last for first, last in self.skip)


def find_key_frames(
    film: Film, options: KeyFrameOptions | None = None, on_step: ProgressCallback = ignore_progress
) -> list[KeyFrame]:
    """Find the key frames of a film, in chronological order.

    There are fewer than requested if the film does not have that many frames.

    Raises:
        InputError: the film cannot be read, or contains no frame that can be printed.
        UsageError: the options contradict each other or the film.
    """
    options = options or KeyFrameOptions()
    options.check()
    survey = film.survey(on_step)
    forced = _find_requested(film, survey, options)
    left = [each for each in survey.candidates if not options.skips(each.time)]
    seen = replace(survey, candidates=left)
    if options.panels is None:
        forced = _add_panels_for_words(forced, left, options.words)
    chosen = choose(seen, forced, options.panels, options.min_panels, options.spoken, options.seed)
    if not chosen:
        if left:
            raise InputError(film.name, *_describe_unusable(left))
        raise UsageError("--skip", "leaves no frame of the film")
    better = _refine(film, chosen, survey, options, on_step)
    weights = importance(better, survey)
    weighted = [replace(each, importance=weight) for each, weight in zip(better, weights, strict=True)]
    if survey.is_folder:
        return list(weighted)
    framed = alternate_framing(weighted)
    if options.panels is not None:
        return list(framed)
    if options.min_panels:
        return list(prune(framed, options.min_panels))
    return list(merge_equal(prune(remove_repeats(framed), len(forced))))


def _describe_unusable(candidates: Sequence[Candidate]) -> tuple[str, ...]:
    """Explain why no frame of a film can be printed, and what helps."""
    if all(each.blank or each.test_picture for each in candidates):
        return ("holds only blank frames",)
    return "holds no frame without damage, a dissolve or a fade", "print one nevertheless with --at SECONDS"


def _find_requested(film: Film, survey: Survey, options: KeyFrameOptions) -> list[Candidate]:
    last = max(survey.seconds, survey.candidates[-1].time)
    for time in options.at:
        if time > last + 1:
            raise UsageError("--at", f"{time:g} s is after the end", f"the film has {last:.1f} s")
    found = {}
    for time in options.at:
        each = film.at(time)
        scene = max(0, bisect_right(survey.scene_starts, each.time) - 1)
        found[each.time] = replace(each, scene=scene, forced=True)
    return [found[time] for time in sorted(found)]


def _add_panels_for_words(
    forced: Sequence[Candidate], candidates: Sequence[Candidate], words: Sequence[float]
) -> list[Candidate]:
    """Return the forced frames and, for each time of words, the nearest usable frame not yet taken."""
    found = {each.time: each for each in forced}
    usable = usable_candidates(candidates)
    for time in words:
        free = [each for each in usable if each.time not in found]
        if free and len(found) < MAX_DEFAULT_PANELS:
            nearest = min(free, key=lambda each: abs(each.time - time))
            found[nearest.time] = replace(nearest, forced=True)
    return [found[time] for time in sorted(found)]


def _refine(
    film: Film,
    chosen: Sequence[Candidate],
    survey: Survey,
    options: KeyFrameOptions,
    on_step: ProgressCallback,
) -> list[Candidate]:
    """Replace each frame by a better one near it, if there is one that is no more similar to the others."""
    refined, neighbours = list(chosen), [list[Candidate]() for _ in chosen]
    for number, each in enumerate(chosen):
        on_step("choosing key frames", number, len(chosen))
        if each.forced:
            continue
        others = refined[max(0, number - LOOKBACK_PANELS) : number] + refined[number + 1 :][:LOOKBACK_PANELS]
        after = refined[number - 1].time if number else -math.inf
        before = refined[number + 1].time if number + 1 < len(refined) else math.inf
        nearby = [
            other
            for other in film.around(each)
            if after < other.time < before and not (other.is_flawed or options.skips(other.time))
        ]
        nearby = _keep_distinct(nearby, each, others) or [replace(film.at(each.time), scene=each.scene)]
        nearby = add_actions(nearby, [other for other in survey.candidates if other.scene == each.scene])
        nearby = _keep_subject(nearby, each)
        likely = sorted(nearby, key=_score_relative_to(nearby), reverse=True)[:_MAX_FACE_CANDIDATES]
        with_faces = film.with_large_faces(likely)
        refined[number] = max(with_faces, key=_score_relative_to(with_faces))
        neighbours[number] = [other for other in with_faces if other is not refined[number]]
    return film.with_subjects(refined, neighbours)


def _keep_subject(nearby: Sequence[Candidate], each: Candidate) -> list[Candidate]:
    """Return the frames near a candidate that show its moving subject; all of them if it has none.

    The candidate's own frame has its subject, and is the last resort.
    """
    if each.action is None:
        return list(nearby)
    known = [replace(other, action=each.action) if other.time == each.time else other for other in nearby]
    shown = [other for other in known if other.action and not other.action.is_gone]
    return shown or known


def _keep_distinct(
    nearby: Sequence[Candidate], each: Candidate, others: Sequence[Candidate]
) -> list[Candidate]:
    """Return the frames near a candidate that are no more similar to any of the others than it is."""
    if not others:
        return list(nearby)
    like = similarity([candidate.thumbnail for candidate in (each, *nearby, *others)])
    most = like[: -len(others), -len(others) :].max(axis=1)
    limit = max(DIFFERENT_SIMILARITY, most[0])
    return [other for other, like in zip(nearby, most[1:], strict=True) if like <= limit]


def _score_relative_to(nearby: Sequence[Candidate]) -> Callable[[Candidate], float]:
    """Return a function that scores a frame by its features, relative to the best of the frames near it."""
    sharpest, clearest, most_open = (
        max((getattr(each, name) for each in nearby), default=0.0) or 1.0
        for name in ("sharpness", "clarity", "eyes")
    )
    faces = max(len(each.faces) for each in nearby)
    return lambda each: (
        each.sharpness / sharpest
        + _CLARITY_WEIGHT * each.clarity / clearest
        - _MOTION_WEIGHT * min(1.0, each.motion)
        - _FLOW_WEIGHT * min(1.0, subject_flow(each) / MAX_PICTURE_FLOW)
        + (
            _ACTION_WEIGHT * (each.action.share - _CUT_FACTOR * each.action.cut)
            if each.action and not each.faces
            else 0
        )
        + (_EYES_WEIGHT * each.eyes / most_open + _FACES_WEIGHT * len(each.faces) / faces if faces else 0)
    )
