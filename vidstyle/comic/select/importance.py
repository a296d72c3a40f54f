"""The importance of chosen frames, which decides the size of their panels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.select.frame_scores import (
    MAX_LEADING_SOFTNESS,
    clutter,
    face_softness,
    has_figure,
    is_person,
    scene_values,
    subject_strength,
)

_SUBJECT_WEIGHT, _SCENE_SHARE_WEIGHT, _QUALITY_WEIGHT, _FORCED_WEIGHT = 0.8, 0.15, 0.25, 0.25
"""Weights of the subject, of the frame's share of its scene, of its quality, and of a request."""
_MAX_PLACE_IMPORTANCE_RATIO = 0.8
"""Maximum importance of other frames, relative to the most important one with a subject."""
_FULL_RESOLUTION_PX = 300.0
"""Resolution from which a picture may have a panel of any size, see `measure_resolution`.

Of 56 panels on pages that a judge had seen, the three that were called out of focus have 170 to 220, others
mostly 250 to 420.
"""
_MIN_LEGIBLE_SHARE, _FULL_CLARITY, _FULL_LIGHT = 0.3, 0.8, 0.35
"""Share of its importance that an illegible picture keeps, and clarity and mean luma of a legible one."""


def _legibility(candidate: Candidate) -> float:
    """Return the factor on the importance of a frame for clutter, darkness, blur and murk: 0.3..1."""
    clear = min(1.0, candidate.clarity / _FULL_CLARITY) * min(1.0, candidate.light / _FULL_LIGHT)
    clear *= (1 - clutter(candidate)) * min(1.0, candidate.resolution / _FULL_RESOLUTION_PX)
    return _MIN_LEGIBLE_SHARE + (1 - _MIN_LEGIBLE_SHARE) * clear


def importance(chosen: Sequence[Candidate], survey: Survey) -> list[float]:
    """Return the importance of each chosen frame, 0..1, the most important one 1.

    Subjects count most, so that people and what moves are shown large and places small. The value of a scene
    is divided among its frames. Requested frames are more important, and illegible ones less.
    """
    scenes = scene_values(survey)
    counts = np.bincount([each.scene for each in chosen], minlength=len(scenes))
    shown = [
        _legibility(each)
        * (
            _SUBJECT_WEIGHT * subject_strength(each)
            + _SCENE_SHARE_WEIGHT * float(scenes[each.scene]) / counts[each.scene]
            + _QUALITY_WEIGHT * each.clarity * min(1.0, 2 * each.sharpness)
            + _FORCED_WEIGHT * each.forced
        )
        for each in chosen
    ]
    most = max(shown, default=0.0)
    return [float(each / most) if most > 0 else 1.0 for each in shown]


def prefer_subjects(chosen: Sequence[Candidate]) -> list[Candidate]:
    """Return the frames of a film, those without a subject less important than the main one with a subject.

    Subjects are people whose face is sharp, or else what moves. Without either, neither people nor places
    are more important than the main one of the others.
    """
    leading = [each for each in chosen if is_person(each) and face_softness(each) <= MAX_LEADING_SOFTNESS]
    leading = leading or [each for each in chosen if has_figure(each) and not is_person(each)]
    if leading:
        free = {each.time for each in leading}
        most = _MAX_PLACE_IMPORTANCE_RATIO * max(each.importance for each in leading)
    else:
        free = set()
        groups = [[each for each in chosen if is_person(each) == has_person] for has_person in (True, False)]
        most = min(max(each.importance for each in group) for group in groups if group)
    return [
        each if each.forced or each.time in free else replace(each, importance=min(each.importance, most))
        for each in chosen
    ]


def equalize_places(chosen: Sequence[Candidate]) -> list[Candidate]:
    """Return the frames of a page; without any figure, all have the same importance."""
    if any(has_figure(each) or each.forced for each in chosen):
        return list(chosen)
    most = max((each.importance for each in chosen), default=0.0)
    return [replace(each, importance=most) for each in chosen]


def find_weakest(key_frames: Sequence[Candidate], numbers: Sequence[int]) -> int | None:
    """Return the index of the least important one of these frames that was not requested."""
    free = [number for number in numbers if not key_frames[number].forced]
    return min(free, key=lambda number: key_frames[number].importance, default=None)
