"""Scores of scenes and frames relative to the rest of their film."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.comic.analyze.features import Candidate, Survey

_KIN = 0.65
"""Scenes whose colour histograms intersect by more are of one kind, such as two speakers shown in turn."""
_MIXED, _BLURRED, _SOFT, _SOFTEST = 1.0, 0.5, 0.8, 0.4
"""What a picture loses in which two shots are mixed, and at most one that is less sharp than so much of what
is usual: a near face has few edges. A shot may be softer, down to the last, if all of it is."""
_EMPTY = 0.35
"""In a picture that is less clear there is so little to be seen that it matters less how sharp that is."""
_MOVING, _WILD = 0.5, 0.6
"""What a picture loses that is all movement, and how much that is; it is less clear than its edges tell."""
_LARGE_FACE = 0.12
"""The share of the picture of a face that is as good as any larger one."""


def scene_values(survey: Survey) -> np.ndarray:
    """The importance of each scene, 0..1, the most important one 1: of long and rare ones it is high.

    It is L log(1/W), where L is the scene's length and W the share of the film of all scenes of its kind
    (Uchihashi and others 1999).
    """
    count = len(survey.scene_starts)
    ends = [*survey.scene_starts[1:], max(survey.seconds, survey.scene_starts[-1])]
    lengths = np.maximum(np.array(ends) - survey.scene_starts, 1e-3)
    kinds = _scene_groups(survey.candidates, count)
    shares = np.bincount(kinds, lengths, count)[kinds] / lengths.sum()
    values = lengths * np.log(1 / np.minimum(shares, 1))
    return values / values.max() if values.max() > 1e-6 else np.ones(count)


def _scene_groups(candidates: Sequence[Candidate], count: int) -> np.ndarray:
    """The number of the first scene that looks like each scene."""
    histograms = np.zeros((count, len(candidates[0].histogram)) if candidates else (count, 1), np.float32)
    for each in candidates:
        histograms[each.scene] += each.histogram
    histograms /= np.maximum(histograms.sum(axis=1, keepdims=True), 1e-6)
    kinds = np.arange(count)
    for scene in range(1, count):
        shared = np.minimum(histograms[:scene], histograms[scene]).sum(axis=1)
        if shared.max() > _KIN:
            kinds[scene] = kinds[int(shared.argmax())]
    return kinds


def scores(pool: Sequence[Candidate], scenes: np.ndarray) -> np.ndarray:
    """The score of each frame, mostly 0..1.

    Args:
        scenes: the value of each scene, 0..1.
    """
    sharp = np.array([each.sharpness for each in pool])
    clarity = np.array([each.clarity for each in pool])
    shown = clarity >= min(_EMPTY, float(clarity.max()))
    usual = float(np.median(sharp[shown]))
    best = {
        scene: max(each.sharpness for each in pool if each.scene == scene)
        for scene in {each.scene for each in pool}
    }
    sharpest = np.array([best[each.scene] for each in pool])
    beside = sharp / np.maximum(sharpest, 1e-6)
    wanted = np.minimum(_SOFT * usual, np.maximum(sharpest, _SOFTEST * usual))
    rank = sharp.argsort(kind="stable").argsort(kind="stable") / max(len(pool) - 1, 1)
    return (
        (0.15 * rank + 0.25 * beside) * np.minimum(1, clarity / _EMPTY)
        + 0.6 * clarity
        + 0.25 * np.array([face_share(each) for each in pool])
        + 0.3 * np.sqrt(scenes[[each.scene for each in pool]])
        - _MOVING * np.minimum(1, [each.motion / _WILD for each in pool])
        - _MIXED * np.array([each.in_transition for each in pool])
        - _BLURRED * (1 - sharp / np.maximum(wanted, 1e-6)).clip(0, 0.5) * 2
    )


def face_share(candidate: Candidate) -> float:
    """The area of the largest face relative to that in a close-up, 0..1."""
    if not candidate.faces:
        return 0.0
    height, width = candidate.shape
    return min(1.0, candidate.faces[0].area / (height * width) / _LARGE_FACE)


def importance(chosen: Sequence[Candidate], survey: Survey) -> list[float]:
    """The importance of each chosen frame, 0..1, the most important one 1.

    A scene's value is divided among its frames; the rest depends on what they show. Requested frames are
    more important.
    """
    scenes = scene_values(survey)
    counts = np.bincount([each.scene for each in chosen], minlength=len(scenes))
    shown = [
        0.5 * float(scenes[each.scene]) / counts[each.scene]
        + 0.25 * each.clarity * min(1.0, 2 * each.sharpness)
        + 0.25 * face_share(each)
        + 0.25 * each.forced
        for each in chosen
    ]
    most = max(shown, default=0.0)
    return [float(each / most) if most > 0 else 1.0 for each in shown]
