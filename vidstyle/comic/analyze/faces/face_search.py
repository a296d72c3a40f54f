"""Faces of candidate key frames: detected, or followed from other frames of their shot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from vidstyle.comic.analyze.faces.eyes import measure_open_eyes
from vidstyle.comic.analyze.faces.mouths import measure_open_mouth
from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.sharpness import measure_detail
from vidstyle.regions.boxes import Box
from vidstyle.regions.faces import (
    LARGE_FACE_HEIGHT_RATIO,
    MIN_FACE_HEIGHT_RATIO,
    SEARCHED_HEIGHT_RATIO,
    FaceFinder,
)
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS, MarkedFaces

_MIN_FACE_SCORE, _MIN_SCORED_HEIGHT_RATIO = 0.2, 0.2
"""Score below which a face of that height, relative to the picture's, is none, or too smeared to be one:
people and animated animals have 0.26 and more, a face in fast motion 0.16; small faces down to 0.12."""
_FOLLOW_RANGE_RATIO, _MIN_FOLLOW_CORRELATION, _FOLLOWED_HEIGHT_PX = 0.6, 0.6, 32
"""Search range in heights of the face, minimum correlation of the match, and height of the copy of the face
that is searched, as far as whole factors allow."""


def add_faces(
    candidate: Candidate, faces: FaceFinder, only_large: bool = False, others: Sequence[Candidate] = ()
) -> Candidate:
    """Return the candidate with the faces detected in its small copy, if it has one.

    Args:
        candidate: a frame.
        faces: detects them.
        only_large: whether small faces are ignored.
        others: other frames of its shot with their large faces. With two or more of them, a large face counts
            only if it is near one of theirs, and a face that two of them have in common is followed.
    """
    color = candidate.small
    if color is None:
        return candidate
    marks = faces.find(color, SEARCHED_HEIGHT_RATIO if only_large else MIN_FACE_HEIGHT_RATIO)
    factor = candidate.shape[1] / color.shape[1]
    if not only_large:
        marks = {face: each for face, each in marks.items() if _is_face(color, face, faces)}
    if len(others) > 1:
        least, seen = (
            LARGE_FACE_HEIGHT_RATIO * color.shape[0],
            [face.scaled(1 / factor) for each in others for face in each.faces],
        )
        marks = {face: marks[face] for face in marks if face.height < least or _overlaps(face, seen)}
        for face, each in follow_faces(candidate, others).items():
            if not _overlaps(face, list(marks)):
                marks[face] = each
    return _with_faces(candidate, color, marks)


def _with_faces(candidate: Candidate, color: np.ndarray, marks: MarkedFaces) -> Candidate:
    """Return the candidate with faces in its small copy `color`, and the features of the largest one."""
    found = sorted(marks, key=lambda face: -face.area)
    factor = candidate.shape[1] / color.shape[1]
    scaled = {face.scaled(factor): marks[face] for face in found}
    candidate = replace(candidate, faces=tuple(scaled), landmarks=scaled)
    if not found:
        return replace(candidate, face_detail=None, eyes=0.0, open_mouth=0.0)
    luma, main = cv2.cvtColor(color, cv2.COLOR_RGB2GRAY), found[0]
    return replace(
        candidate,
        face_detail=measure_detail(cut_face(color, main)),
        eyes=measure_open_eyes(luma, main, marks[main]),
        open_mouth=measure_open_mouth(luma, main, marks[main].mouth(main)),
    )


def _is_face(color: np.ndarray, face: Box, faces: FaceFinder) -> bool:
    """Whether a detected face is one; small ones always are, so that text keeps clear of them."""
    if face.height < _MIN_SCORED_HEIGHT_RATIO * color.shape[0]:
        return True
    score = faces.score(color, face)
    return score is None or score >= _MIN_FACE_SCORE


def follow_faces(candidate: Candidate, frames: Sequence[Candidate]) -> MarkedFaces:
    """Find faces of other frames again in the small copy of a candidate.

    Two of the frames must have a face in the same place, so that a single error is not followed.

    Returns:
        The faces in pixels of the small copy, and their landmarks.
    """
    found: MarkedFaces = {}
    for each in frames:
        others = [face for other in frames if other is not each for face in other.faces]
        for face in each.faces:
            if _overlaps(face, others) and not _overlaps(face, [*candidate.faces, *found]):
                found |= _follow_face(candidate, each, face)
    return found


def with_followed_faces(candidate: Candidate, other: Candidate) -> Candidate:
    """Return a frame with the faces of another frame of its shot that are found again in its small copy."""
    if candidate.small is None:
        return candidate
    marks: MarkedFaces = {}
    for face in other.faces:
        marks |= _follow_face(candidate, other, face)
    return _with_faces(candidate, candidate.small, marks)


def _follow_face(candidate: Candidate, other: Candidate, face: Box) -> MarkedFaces:
    if candidate.small is None or other.small is None or candidate.small.shape != other.small.shape:
        return {}
    factor = candidate.small.shape[1] / candidate.shape[1]
    height, width = candidate.small.shape[:2]
    place = Box(*map(round, face.scaled(factor))).intersection(Box(0, 0, width, height))
    reach = round(_FOLLOW_RANGE_RATIO * place.height)
    around = place.padded(reach, reach, reach).intersection(Box(0, 0, width, height))
    reduction = max(1, place.height // _FOLLOWED_HEIGHT_PX)
    seen, template = (
        _reduce(picture[box.top : box.bottom, box.left : box.right], reduction)
        for picture, box in ((candidate.small, around), (other.small, place))
    )
    _, likeness, _, (right, down) = cv2.minMaxLoc(cv2.matchTemplate(seen, template, cv2.TM_CCOEFF_NORMED))
    if likeness < _MIN_FOLLOW_CORRELATION:
        return {}
    moved = around.left + reduction * right - place.left, around.top + reduction * down - place.top
    return {place.moved(*moved): other.landmarks.get(face, USUAL_LANDMARKS)}


def _reduce(color: np.ndarray, factor: int) -> np.ndarray:
    """Return a picture, H x W x 3 uint8, reduced by a whole factor."""
    size = tuple(max(1, side // factor) for side in color.shape[1::-1])
    return cv2.resize(color, size, interpolation=cv2.INTER_AREA)


def _overlaps(face: Box, others: Sequence[Box]) -> bool:
    return any(face.intersection(other).area > 0 for other in others)


def cut_face(color: np.ndarray, face: Box) -> np.ndarray:
    """Return the part of a picture, H x W x 3 uint8, that shows a face."""
    height, width = color.shape[:2]
    left, top = min(max(0, round(face.left)), width - 1), min(max(0, round(face.top)), height - 1)
    return color[top : max(top + 1, round(face.bottom)), left : max(left + 1, round(face.right))]
