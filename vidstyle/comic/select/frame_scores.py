"""Scores of single frames relative to their film."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.comic.analyze.features import Candidate, Survey
from vidstyle.comic.analyze.flaws.motion_blur import MAX_PICTURE_FLOW, limb_blur, subject_flow
from vidstyle.comic.analyze.sharpness import FULL_FACE_DETAIL_LEVELS, measure_clutter

_FILM_RANK_WEIGHT, _SCENE_RANK_WEIGHT = 0.15, 0.25
"""Weights of the rank of a frame's sharpness in the film and in its scene."""
_CLARITY_WEIGHT, _FACE_WEIGHT, _SCENE_WEIGHT = 0.6, 0.25, 0.3
"""Weights of clarity, of the largest face and of the value of the scene."""
_OPEN_MOUTH_WEIGHT = 0.25
"""Weight of a mouth that speaks."""
_MIN_GROUP_INTERSECTION = 0.65
"""Scenes with a higher histogram intersection form a group, such as the shots of a speaker in a dialogue."""
_MAX_BLUR_COST = 0.5
"""Maximum cost of blur."""
_MIN_SHARPNESS_RATIO, _MIN_SOFT_SCENE_RATIO = 0.8, 0.4
"""A frame is blurred below this fraction of the median sharpness; the second value is for soft scenes.

The fractions are below 1 as close-ups of faces have few edges.
"""
_MIN_CLARITY = 0.35
"""Clarity below which sharpness counts less, as there is little to see."""
_MAX_MOTION_COST, _MAX_COST_MOTION = 0.5, 0.6
"""Maximum cost of motion, and the motion that has it: motion blur beyond what edges show."""
_MAX_SUBJECT_FLOW_COST = 0.3
"""Maximum cost of a subject that moves fast, so that each is shown where it pauses or turns."""
_MAX_LIMB_COST = 0.6
"""Maximum cost of smeared hands."""
_ACTION_SCORE, _MAX_CUT_SUBJECT_COST = 0.3, 0.8
"""Score of a moving subject, and maximum cost of one that the picture's edge cuts off."""
_SHARP_FACE_RATIO, MAX_LEADING_SOFTNESS = 1.5, 0.3
"""Detail of a sharp face relative to one that survives being drawn; softness up to which a person leads.

Softer faces are not enlarged.
"""
_SOFT_FACE_COST, _SOFT_FACE_STRENGTH_RATIO = 0.5, 0.5
"""Maximum cost of a large face that is not sharp, and how much weaker a subject it is at most."""
_SMEARED_SUBJECT_COST = 0.8
"""Cost of a moving subject that is not as sharp as in other frames, relative to their sharpness."""
_TITLE_COST = 0.8
"""Cost of a title over a picture, if its scene has frames without one."""
_CLUTTER_COST = 0.4
"""Cost of a picture that is nothing but edges, in which style and reader lose the subject."""
_FACE_SUBJECT_SCORE, _ACTION_SUBJECT_SCORE, _SALIENT_SUBJECT_SCORE = 0.6, 0.65, 0.4
"""Strength of a small face, of something that moves, and of the smallest salient area."""
_MAX_SUBJECT_AREA_SHARE = 0.5
"""Share of the picture from which a salient area is no subject."""
_FULL_SCORE_FACE_SHARE = 0.12
"""Share of the picture from which a larger face scores no higher."""

_MIN_SUBJECT_STRENGTH = 0.1
"""Strength from which a frame has a subject, see `subject_strength`."""
_MIN_PERSON_RATIO = 0.15
"""Height of a face, relative to the picture's, from which a frame shows a person."""


def scene_values(survey: Survey) -> np.ndarray:
    """Return the importance of each scene, 0..1, the most important one 1; high for long and rare scenes.

    L log(1/W), where L is the length of the scene and W the share of its group of scenes in the film
    (Uchihashi et al. 1999).
    """
    count = len(survey.scene_starts)
    ends = [*survey.scene_starts[1:], max(survey.seconds, survey.scene_starts[-1])]
    lengths = np.maximum(np.array(ends) - survey.scene_starts, 1e-3)
    kinds = _scene_groups(survey.candidates, count)
    shares = np.bincount(kinds, lengths, count)[kinds] / lengths.sum()
    values = lengths * np.log(1 / np.minimum(shares, 1))
    return values / values.max() if values.max() > 1e-6 else np.ones(count)


def _scene_groups(candidates: Sequence[Candidate], count: int) -> np.ndarray:
    """Return, for each scene, the index of the first scene that looks like it."""
    histograms = np.zeros((count, len(candidates[0].histogram)) if candidates else (count, 1), np.float32)
    for each in candidates:
        histograms[each.scene] += each.histogram
    histograms /= np.maximum(histograms.sum(axis=1, keepdims=True), 1e-6)
    kinds = np.arange(count)
    for scene in range(1, count):
        shared = np.minimum(histograms[:scene], histograms[scene]).sum(axis=1)
        if shared.max() > _MIN_GROUP_INTERSECTION:
            kinds[scene] = kinds[int(shared.argmax())]
    return kinds


def scores(pool: Sequence[Candidate], scenes: np.ndarray) -> np.ndarray:
    """Return the score of each frame, mostly 0..1.

    Args:
        pool: the frames.
        scenes: the value of each scene, 0..1.
    """
    sharp = np.array([each.sharpness for each in pool])
    clarity = np.array([each.clarity for each in pool])
    is_clear = clarity >= min(_MIN_CLARITY, float(clarity.max()))
    median = float(np.median(sharp[is_clear]))
    sharpest_by_scene = {
        scene: max(each.sharpness for each in pool if each.scene == scene)
        for scene in {each.scene for each in pool}
    }
    sharpest = np.array([sharpest_by_scene[each.scene] for each in pool])
    scene_rank = sharp / np.maximum(sharpest, 1e-6)
    wanted = np.minimum(_MIN_SHARPNESS_RATIO * median, np.maximum(sharpest, _MIN_SOFT_SCENE_RATIO * median))
    film_rank = sharp.argsort(kind="stable").argsort(kind="stable") / max(len(pool) - 1, 1)
    return (
        (_FILM_RANK_WEIGHT * film_rank + _SCENE_RANK_WEIGHT * scene_rank)
        * np.minimum(1, clarity / _MIN_CLARITY)
        + _CLARITY_WEIGHT * clarity
        + _FACE_WEIGHT * np.array([face_share(each) for each in pool])
        + _OPEN_MOUTH_WEIGHT * np.array([each.open_mouth for each in pool])
        + _SCENE_WEIGHT * np.sqrt(scenes[[each.scene for each in pool]])
        - _MAX_MOTION_COST * np.minimum(1, [each.motion / _MAX_COST_MOTION for each in pool])
        - _MAX_SUBJECT_FLOW_COST * np.minimum(1, [subject_flow(each) / MAX_PICTURE_FLOW for each in pool])
        - _MAX_LIMB_COST * np.array([limb_blur(each) for each in pool])
        + np.array([_action_value(each) for each in pool])
        - _TITLE_COST * _avoidable_titles(pool)
        - _SMEARED_SUBJECT_COST * (1 - np.array([each.sharp_subject for each in pool]))
        - _CLUTTER_COST * np.array([clutter(each) for each in pool])
        - _SOFT_FACE_COST * np.array([face_softness(each) for each in pool])
        - _MAX_BLUR_COST * (1 - sharp / np.maximum(wanted, 1e-6)).clip(0, 0.5) * 2
    )


def _avoidable_titles(pool: Sequence[Candidate]) -> np.ndarray:
    """Return which frames show a title, while others of their scene show none."""
    free = {each.scene for each in pool if not each.titled}
    return np.array([each.titled and each.scene in free for each in pool], float)


def _action_value(candidate: Candidate) -> float:
    if candidate.action is None or candidate.faces:
        return _ACTION_SCORE / 2
    return _ACTION_SCORE * candidate.action.share - _MAX_CUT_SUBJECT_COST * candidate.action.cut


def face_share(candidate: Candidate) -> float:
    """Return the area of the largest face relative to a face in a close-up, 0..1."""
    if not candidate.faces:
        return 0.0
    height, width = candidate.shape
    return min(1.0, candidate.faces[0].area / (height * width) / _FULL_SCORE_FACE_SHARE)


def face_softness(candidate: Candidate) -> float:
    """Return how far the main face of a frame is from sharp, 0..1; 0 for small faces."""
    if candidate.face_detail is None or not is_person(candidate):
        return 0.0
    return max(0.0, 1 - candidate.face_detail / (_SHARP_FACE_RATIO * FULL_FACE_DETAIL_LEVELS))


def is_person(candidate: Candidate) -> bool:
    """Whether a frame shows a person near enough to be recognized."""
    height = candidate.faces[0].height if candidate.faces else 0.0
    return height >= _MIN_PERSON_RATIO * candidate.shape[0]


def subject_strength(candidate: Candidate) -> float:
    """Return how clearly a frame shows a subject, 0..1: a face, a moving object, or a small salient area."""
    if candidate.faces:
        strength = _FACE_SUBJECT_SCORE + (1 - _FACE_SUBJECT_SCORE) * face_share(candidate)
        return strength * (1 - _SOFT_FACE_STRENGTH_RATIO * face_softness(candidate))
    if candidate.action and not candidate.action.is_gone:
        return _ACTION_SUBJECT_SCORE * candidate.action.share * (1 - candidate.action.cut)
    height, width = candidate.shape
    compact = 1 - candidate.saliency.area / (_MAX_SUBJECT_AREA_SHARE * height * width)
    return _SALIENT_SUBJECT_SCORE * max(0.0, compact)


def has_subject(candidate: Candidate) -> bool:
    """Whether a frame shows a subject, see `subject_strength`."""
    return subject_strength(candidate) >= _MIN_SUBJECT_STRENGTH


def clutter(candidate: Candidate) -> float:
    """Return how much a frame consists of edges, 0..1, less for a large face; 0 if it is not known."""
    found = 0.0 if candidate.detail is None else measure_clutter(candidate.detail)
    return found * (1 - face_share(candidate))


def has_figure(candidate: Candidate) -> bool:
    """Whether a frame shows a face or something that moves."""
    return bool(candidate.faces) or (candidate.action is not None and not candidate.action.is_gone)
