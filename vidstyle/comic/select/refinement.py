"""The search for a better frame near each chosen one."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

from vidstyle.comic.analyze.faces.face_search import with_followed_faces
from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.analyze.flaws.motion_blur import MAX_PICTURE_FLOW, limb_blur, subject_flow
from vidstyle.comic.analyze.key_frame_source import Film
from vidstyle.comic.analyze.moving.action import add_actions
from vidstyle.comic.analyze.moving.subject_sharpness import compare_subject
from vidstyle.comic.analyze.similarity import DIFFERENT_SIMILARITY, similarity
from vidstyle.comic.select.best_path import LOOKBACK_PANELS
from vidstyle.core.machine.cores import single_threaded_opencv
from vidstyle.pipeline.progress import ProgressCallback
from vidstyle.regions.faces import LARGE_FACE_HEIGHT_RATIO

_CUT_FACTOR = 2.0
"""How much more it counts that a subject is cut off than that it is large."""
_MIN_SUBJECT_AREA_RATIO = 0.7
"""Area of a moving subject in a better frame, relative to the chosen one: it may come from afar."""
_MAX_FACE_CANDIDATES = 3
"""Number of frames near a chosen one in which faces are detected: the best by all other features."""
_SIMILARITY_TOLERANCE = 0.05
"""How much more similar to another panel a better frame may be."""
_CLARITY_WEIGHT, _MOTION_WEIGHT, _FLOW_WEIGHT, _LIMB_WEIGHT = 0.8, 0.5, 0.5, 0.6
_ACTION_WEIGHT, _EYES_WEIGHT, _FACES_WEIGHT, _SHARP_SUBJECT_WEIGHT, _TITLE_WEIGHT = 0.5, 1.0, 0.3, 2.0, 0.5
_MOUTH_WEIGHT = 0.6
"""Weights of the features by which frames of one shot are compared, relative to sharpness."""


class Refinement:
    """Replaces chosen frames by better ones near them, each once.

    Args:
        film: the source.
        survey: of the whole film.
        skips: tells times that are excluded.
        on_step: called with the name of a step and its progress.
    """

    def __init__(
        self, film: Film, survey: Survey, skips: Callable[[float], bool], on_step: ProgressCallback
    ) -> None:
        self._film, self._survey, self._skips, self._on_step = film, survey, skips, on_step
        self._done = dict[float, Candidate]()

    @single_threaded_opencv()  # frames are measured side by side
    def refine(self, chosen: Sequence[Candidate]) -> list[Candidate]:
        """Return better frames that are hardly more similar to the others, with their subjects."""
        refined = [self._done.get(each.time, each) for each in chosen]
        new = [number for number, each in enumerate(chosen) if each.time not in self._done]
        neighbours = dict.fromkeys(new, list[Candidate]())
        for number in new:
            self._on_step("choosing key frames", number, len(chosen))
            if not chosen[number].forced:
                best, *neighbours[number] = self._candidates(chosen[number], refined, number)
                refined[number] = best
        searched = [neighbours[number] if chosen[number].faces else [] for number in new]
        found = self._film.with_subjects([refined[number] for number in new], searched)
        for number, each in zip(new, found, strict=True):
            if _has_large_face(each) and not chosen[number].faces:
                each = self._confirm(refined[number], neighbours[number])
            refined[number] = self._done[chosen[number].time] = each
        return refined

    def _confirm(self, best: Candidate, neighbours: Sequence[Candidate]) -> Candidate:
        """Return a frame with its subjects; large faces count if its neighbours have them, too."""
        (found,) = self._film.with_subjects([best], [self._film.with_large_faces(neighbours)])
        return found

    def _candidates(self, each: Candidate, refined: Sequence[Candidate], number: int) -> list[Candidate]:
        """Return the likely frames near a chosen one, the best first; large faces only if it has any.

        Faces are detected in a few frames, and followed to all others: eyes blink for a few frames.
        """
        others = [
            *refined[max(0, number - LOOKBACK_PANELS) : number],
            *refined[number + 1 :][:LOOKBACK_PANELS],
        ]
        after = refined[number - 1].time if number else -math.inf
        before = refined[number + 1].time if number + 1 < len(refined) else math.inf
        nearby = [
            other
            for other in self._film.around(each)
            if after < other.time < before and not (other.is_flawed or self._skips(other.time))
        ]
        nearby = _keep_distinct(nearby, each, others) or [replace(self._film.at(each.time), scene=each.scene)]
        nearby = add_actions(
            nearby, [other for other in self._survey.candidates if other.scene == each.scene]
        )
        sharpest = self._survey.sharpest_subjects.get(each.scene, 0.0)
        nearby = [compare_subject(other, sharpest) for other in _keep_subject(nearby, each)]
        nearby = [other for other in nearby if not other.blurred] or nearby
        likely = sorted(nearby, key=_score_relative_to(nearby), reverse=True)[:_MAX_FACE_CANDIDATES]
        if not each.faces:
            return likely
        found = self._film.with_large_faces(likely)
        best = max(compared := [*found, *_follow_faces(nearby, found)], key=_score_relative_to(compared))
        return [best, *(other for other in found if other is not best)]


def _follow_faces(nearby: Sequence[Candidate], found: Sequence[Candidate]) -> list[Candidate]:
    """Return the frames in which no face was looked for, with the faces of the nearest one that has any."""
    known, seen = {each.time for each in found}, [each for each in found if each.faces]
    return [
        with_followed_faces(each, min(seen, key=lambda other: abs(other.time - each.time)))
        for each in nearby
        if seen and each.time not in known
    ]


def _has_large_face(candidate: Candidate) -> bool:
    return any(face.height >= LARGE_FACE_HEIGHT_RATIO * candidate.shape[0] for face in candidate.faces)


def _keep_subject(nearby: Sequence[Candidate], each: Candidate) -> list[Candidate]:
    """Return the frames near a candidate that show its moving subject as large or less cut off.

    They are all frames if it has none. The candidate's own frame has its subject, and is the last resort.
    """
    action = each.action
    if action is None:
        return list(nearby)
    known = [replace(other, action=action) if other.time == each.time else other for other in nearby]
    least = _MIN_SUBJECT_AREA_RATIO * float(action.places.mean())
    shown = [
        other
        for other in known
        if other.action
        and not other.action.is_gone
        and (other.action.places.mean() >= least or other.action.cut < action.cut)
    ]
    return shown or known


def _keep_distinct(
    nearby: Sequence[Candidate], each: Candidate, others: Sequence[Candidate]
) -> list[Candidate]:
    """Return the frames near a candidate that are hardly more similar to any of the others than it is."""
    if not others:
        return list(nearby)
    like = similarity([candidate.thumbnail for candidate in (each, *nearby, *others)])
    most = like[: -len(others), -len(others) :].max(axis=1)
    limit = max(DIFFERENT_SIMILARITY, most[0] + _SIMILARITY_TOLERANCE)
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
        - _LIMB_WEIGHT * limb_blur(each)
        + _SHARP_SUBJECT_WEIGHT * each.sharp_subject
        - _TITLE_WEIGHT * each.titled
        + _MOUTH_WEIGHT * each.open_mouth
        + (
            _ACTION_WEIGHT * (each.action.share - _CUT_FACTOR * each.action.cut)
            if each.action and not each.faces
            else 0
        )
        + (_EYES_WEIGHT * each.eyes / most_open + _FACES_WEIGHT * len(each.faces) / faces if faces else 0)
    )
