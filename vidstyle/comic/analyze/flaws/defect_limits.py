"""Defects of frames compared with their film: damage and blur."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.flaws.flat_boxes import is_sudden
from vidstyle.comic.analyze.flaws.motion_blur import MAX_PICTURE_FLOW, region_flow
from vidstyle.comic.analyze.sharpness import lacks_detail
from vidstyle.comic.analyze.similarity import SAME_SIMILARITY, similarity
from vidstyle.regions.boxes import Box

# Damage that the decoder does not report.
_BLOCKINESS_FACTOR, _BLOCKINESS_TOLERANCE, _MIN_BLOCKINESS_LIMIT = 1.2, 0.06, 0.27
"""A frame is damaged above this multiple of what the film's textures have off the grid, plus the margin.

They were tuned on four damaged copies of films, whose undamaged copies are never above it.
"""
_USUAL_BLOCKINESS_FACTOR = 1.5
"""A damaged frame also exceeds this multiple of the usual one of the film, in case of strong compression."""
_USUAL_PERCENTILE = 25
"""Percentile that represents the usual blockiness of a film and corners of a scene: most may be damaged."""
_TEXTURE_PERCENTILE = 98
"""The percentile of all frames that represents the film's textures."""

_MIN_CORNERS_LIMIT, _USUAL_CORNERS_FACTOR, _CORNERS_TOLERANCE = 14, 3, 8
"""A frame is damaged above the first value and this multiple of the film's median, plus the tolerance.

They were tuned on a damaged trailer that was scaled and encoded again, which has 40 to 70, and on five
undamaged films, which have up to 13.
"""
_SCENE_CORNERS_FACTOR, _MAX_SCENE_LIMIT = 1.5, 34
"""The limit is raised to this multiple of the usual number in a scene, plus the tolerance, but not beyond the
second value: windows, bricks and signs have corners, too."""
_MAX_DAMAGE_GAP_SECONDS = 2.5
"""Time between two damaged frames of a scene in which the other frames are damaged, too."""
_MIN_NEARBY_CORNERS, _MAX_SPREAD_SECONDS = 6, 0.6
"""A frame of the same scene within this time of a damaged one is damaged from this number of corners."""

# Blur, relative to the film and to the scene.
_SHARP_PERCENTILE = 80
"""Percentile of the film's sharpness that is called sharp."""
_STILL_BLUR_RATIO, _MAX_BLUR_RATIO = 0.38, 0.75
"""A moving frame is blurred below this fraction of the sharpness; the second value is for strong motion."""
_FAST_MOTION, _FAST_BLUR_RATIO = 0.65, 1.0
"""Motion from which a frame must be as sharp as the film's sharp ones: its hard edges may be doubled."""
_BLUR_RATIO_OFFSET, _MOTION_BLUR_FACTOR = 0.2, 0.7
"""The fraction grows with motion: offset and slope. Soft close-ups move less than blurred frames.

They were tuned on 281 frames of a trailer, which were looked at.
"""
_MIN_BLUR_MOTION = 0.05
"""Motion from which a frame counts as moving: a still one that is soft is so on purpose."""
_NEARBY_BLUR_RATIO, _NEARBY_SECONDS = 0.72, 1.2
"""Any frame is blurred below this fraction of the best sharpness of its scene within this time around it."""
_MIN_SHARPNESS_COUNT = 3
"""Number of frames from which their sharpness can be compared."""


@dataclass(frozen=True)
class DefectLimits:
    """The limits of a film beyond which frames are damaged or blurred.

    Attributes:
        blockiness: the highest one without damage.
        corners: the highest number of corners of blocks without damage in each scene.
        broken: scene and time of each candidate with more corners.
        sharpness: of the film's sharp frames.
        by_scene: time and sharpness of the candidates of each scene, without scenes in which something moves
            before a still camera: there, sharpness changes with the subject, and the rest is not blurred.
        clear: the candidates without defects, with whose detail others are compared.
        flat_boxes: time and flat rectangle of each candidate.
    """

    blockiness: float
    corners: dict[int, float]
    broken: list[tuple[int, float]]
    sharpness: float
    by_scene: dict[int, list[tuple[float, float]]]
    clear: list[Candidate]
    flat_boxes: list[tuple[float, Box | None]]

    @classmethod
    def of(cls, candidates: Sequence[Candidate]) -> DefectLimits:
        """Measure the limits on the candidates of a film."""
        texture = float(np.percentile([each.blockiness.off_grid for each in candidates], _TEXTURE_PERCENTILE))
        usual = float(np.percentile([each.blockiness.on_grid for each in candidates], _USUAL_PERCENTILE))
        highest = max(_BLOCKINESS_FACTOR * texture, _USUAL_BLOCKINESS_FACTOR * usual) + _BLOCKINESS_TOLERANCE
        blockiness = max(_MIN_BLOCKINESS_LIMIT, highest)
        corners = _corner_limits(candidates)
        broken = [(each.scene, each.time) for each in candidates if each.block_corners > corners[each.scene]]
        flat_boxes = [(each.time, each.flat_box) for each in candidates]
        clear = [each for each in candidates if not replace(each, combed=False).is_flawed]
        if len(clear) < _MIN_SHARPNESS_COUNT:
            return cls(blockiness, corners, broken, 0.0, {}, clear, flat_boxes)
        by_scene: dict[int, list[tuple[float, float]]] = {}
        still = {each.scene for each in candidates if each.action}
        for each in clear:
            if each.scene not in still:
                by_scene.setdefault(each.scene, []).append((each.time, each.sharpness))
        sharp = float(np.percentile([each.sharpness for each in clear], _SHARP_PERCENTILE))
        return cls(blockiness, corners, broken, sharp, by_scene, clear, flat_boxes)

    def mark(self, candidate: Candidate) -> Candidate:
        """Return a candidate that is marked if it is damaged or blurred."""
        broken = (
            candidate.broken
            or candidate.blockiness.on_grid > self.blockiness
            or candidate.block_corners > self.corners.get(candidate.scene, np.inf)
            or (candidate.block_corners >= _MIN_NEARBY_CORNERS and self._is_near_broken(candidate))
            or is_sudden(candidate.flat_box, candidate.time, self.flat_boxes)
        )
        blurred = self._is_blurred(candidate) or self._lacks_detail(candidate)
        return replace(candidate, damaged=candidate.damaged or broken, broken=broken, blurred=blurred)

    def _is_near_broken(self, candidate: Candidate) -> bool:
        return any(
            scene == candidate.scene and abs(time - candidate.time) <= _MAX_SPREAD_SECONDS
            for scene, time in self.broken
        )

    def _lacks_detail(self, candidate: Candidate) -> bool:
        around = [
            each
            for each in self.clear
            if each.detail is not None and abs(each.time - candidate.time) <= _NEARBY_SECONDS
        ]
        near = [each.detail for each in _of_same_view(candidate, around) if each.detail is not None]
        known = candidate.detail
        return known is not None and len(near) >= _MIN_SHARPNESS_COUNT and lacks_detail(known, near)

    def _is_blurred(self, candidate: Candidate) -> bool:
        if candidate.scene not in self.by_scene:
            return False
        near = (
            sharpness
            for time, sharpness in self.by_scene[candidate.scene]
            if abs(time - candidate.time) <= _NEARBY_SECONDS
        )
        limit = _NEARBY_BLUR_RATIO * max(near, default=0.0)
        if candidate.motion > _MIN_BLUR_MOTION:
            moving = _BLUR_RATIO_OFFSET + _MOTION_BLUR_FACTOR * candidate.motion
            ratio = min(_MAX_BLUR_RATIO, max(_STILL_BLUR_RATIO, moving))
            ratio = _FAST_BLUR_RATIO if candidate.motion >= _FAST_MOTION else ratio
            limit = max(limit, ratio * self.sharpness)
        if region_flow(candidate) > MAX_PICTURE_FLOW:
            limit = max(limit, self.sharpness)
        return candidate.sharpness < limit


def _corner_limits(candidates: Sequence[Candidate]) -> dict[int, float]:
    """Return for each scene the highest number of corners without damage."""
    usual = _USUAL_CORNERS_FACTOR * float(np.median([each.block_corners for each in candidates]))
    limit = max(_MIN_CORNERS_LIMIT, usual + _CORNERS_TOLERANCE)
    by_scene: dict[int, list[int]] = {}
    for each in candidates:
        by_scene.setdefault(each.scene, []).append(each.block_corners)
    raised = {
        scene: _SCENE_CORNERS_FACTOR * float(np.percentile(counts, _USUAL_PERCENTILE)) + _CORNERS_TOLERANCE
        for scene, counts in by_scene.items()
    }
    return {scene: max(limit, min(_MAX_SCENE_LIMIT, each)) for scene, each in raised.items()}


def _of_same_view(candidate: Candidate, others: Sequence[Candidate]) -> list[Candidate]:
    """Return the frames of the same scene or with a similar picture: sudden blur looks like a cut."""
    same = [each for each in others if each.scene == candidate.scene]
    apart = [each for each in others if each.scene != candidate.scene]
    like = similarity([each.thumbnail for each in (candidate, *apart)])[0, 1:] if apart else ()
    return [*same, *(each for each, value in zip(apart, like, strict=True) if value > SAME_SIMILARITY)]


def spread_damage(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Mark as damaged what follows a damaged candidate until the next key frame: it is predicted from it."""
    marked: list[Candidate] = []
    run = -1
    for each in candidates:
        run = each.key_run if each.damaged else run
        marked.append(replace(each, damaged=each.key_run == run))
    return marked


def fill_damage(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Mark candidates as damaged between two damaged ones of a scene that are near each other.

    It is for films in which the decoder reports nothing: they were damaged before they were encoded again,
    and their key frames do not end the damage.
    """
    broken = [each for each in candidates if each.damaged]
    gaps = [
        (first.time, last.time)
        for first, last in pairwise(broken)
        if first.scene == last.scene and last.time - first.time <= _MAX_DAMAGE_GAP_SECONDS
    ]
    return [
        replace(each, damaged=each.damaged or any(first < each.time < last for first, last in gaps))
        for each in candidates
    ]


def damaged_spans(candidates: Sequence[Candidate]) -> list[tuple[float, float]]:
    """Return first and last time in seconds of each part of a film whose candidates are damaged.

    A part reaches half way to the candidates before and after it. Frames that are shown shortly before the
    first damaged one may be predicted from it, too.
    """
    spans = list[tuple[float, float]]()
    for before, each in zip([None, *candidates], candidates, strict=False):
        if each.damaged and before is not None and before.damaged:
            spans[-1] = spans[-1][0], each.time
        elif each.damaged:
            start = (before.time + each.time) / 2 if before else 0.0
            spans.append((start, each.time))
    return spans
