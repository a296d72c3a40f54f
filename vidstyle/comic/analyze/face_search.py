"""Faces of candidate key frames: detected, or followed from other frames of their shot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.mouths import measure_open_mouth
from vidstyle.comic.analyze.sharpness import measure_detail
from vidstyle.regions.boxes import Box, Point
from vidstyle.regions.faces import (
    LARGE_FACE_HEIGHT_RATIO,
    MIN_FACE_HEIGHT_RATIO,
    SEARCHED_HEIGHT_RATIO,
    FaceFinder,
)

_MIN_FACE_SCORE, _MIN_SCORED_HEIGHT_RATIO = 0.2, 0.2
"""Score below which a face of that height, relative to the picture's, is none, or too smeared to be one:
people and animated animals have 0.26 and more, a face in fast motion 0.16; small faces down to 0.12."""
_FOLLOW_RANGE_RATIO, _MIN_FOLLOW_CORRELATION = 0.6, 0.6
"""Search range in heights of the face, and minimum correlation of the match."""


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
    searched = SEARCHED_HEIGHT_RATIO if only_large else MIN_FACE_HEIGHT_RATIO
    mouths = {face: marks.mouth(face) for face, marks in faces.find(color, searched).items()}
    factor = candidate.shape[1] / color.shape[1]
    if not only_large:
        mouths = {face: mouth for face, mouth in mouths.items() if _is_face(color, face, faces)}
    if len(others) > 1:
        least, seen = (
            LARGE_FACE_HEIGHT_RATIO * color.shape[0],
            [face.scaled(1 / factor) for each in others for face in each.faces],
        )
        mouths = {face: mouths[face] for face in mouths if face.height < least or _overlaps(face, seen)}
        for face, mouth in follow_faces(candidate, others).items():
            if not _overlaps(face, list(mouths)):
                mouths[face] = mouth
    found = sorted(mouths, key=lambda face: -face.area)
    luma = cv2.cvtColor(color, cv2.COLOR_RGB2GRAY)
    eyes = eye_contrast(luma, found[0]) if found else 0.0
    detail = measure_detail(cut_face(color, found[0])) if found else None
    opening = measure_open_mouth(luma, found[0], mouths[found[0]]) if found else 0.0
    scaled = {face.scaled(factor): (mouths[face][0] * factor, mouths[face][1] * factor) for face in found}
    found_in = replace(candidate, faces=tuple(scaled), mouths=scaled, face_detail=detail)
    return replace(found_in, eyes=eyes, open_mouth=opening)


def _is_face(color: np.ndarray, face: Box, faces: FaceFinder) -> bool:
    """Whether a detected face is one; small ones always are, so that text keeps clear of them."""
    if face.height < _MIN_SCORED_HEIGHT_RATIO * color.shape[0]:
        return True
    score = faces.score(color, face)
    return score is None or score >= _MIN_FACE_SCORE


def follow_faces(candidate: Candidate, frames: Sequence[Candidate]) -> dict[Box, Point]:
    """Find faces of other frames again in the small copy of a candidate.

    Two of the frames must have a face in the same place, so that a single error is not followed.

    Returns:
        The faces and their mouths, in pixels of the small copy.
    """
    found = dict[Box, Point]()
    for each in frames:
        others = [face for other in frames if other is not each for face in other.faces]
        for face in each.faces:
            if _overlaps(face, others) and not _overlaps(face, [*candidate.faces, *found]):
                found |= _follow_face(candidate, each, face)
    return found


def _follow_face(candidate: Candidate, other: Candidate, face: Box) -> dict[Box, Point]:
    if candidate.small is None or other.small is None or candidate.small.shape != other.small.shape:
        return {}
    factor = candidate.small.shape[1] / candidate.shape[1]
    height, width = candidate.small.shape[:2]
    place = Box(*map(round, face.scaled(factor))).intersection(Box(0, 0, width, height))
    reach = round(_FOLLOW_RANGE_RATIO * place.height)
    around = place.padded(reach, reach, reach).intersection(Box(0, 0, width, height))
    seen, template = (
        np.ascontiguousarray(picture[box.top : box.bottom, box.left : box.right])
        for picture, box in ((candidate.small, around), (other.small, place))
    )
    _, likeness, _, (right, down) = cv2.minMaxLoc(cv2.matchTemplate(seen, template, cv2.TM_CCOEFF_NORMED))
    if likeness < _MIN_FOLLOW_CORRELATION:
        return {}
    moved = around.left + right - place.left, around.top + down - place.top
    across, low = other.mouth(face)
    return {place.moved(*moved): (across * factor + moved[0], low * factor + moved[1])}


def _overlaps(face: Box, others: Sequence[Box]) -> bool:
    return any(face.intersection(other).area > 0 for other in others)


def cut_face(color: np.ndarray, face: Box) -> np.ndarray:
    """Return the part of a picture, H x W x 3 uint8, that shows a face."""
    height, width = color.shape[:2]
    left, top = min(max(0, round(face.left)), width - 1), min(max(0, round(face.top)), height - 1)
    return color[top : max(top + 1, round(face.bottom)), left : max(left + 1, round(face.right))]


def eye_contrast(luma: np.ndarray, face: Box) -> float:
    """Return the vertical contrast in the band of a face that contains the eyes, 0..1."""
    top, bottom = round(face.top + 0.25 * face.height), round(face.top + 0.5 * face.height)
    left, right = round(face.left + 0.15 * face.width), round(face.right - 0.15 * face.width)
    band = luma[max(0, top) : bottom, max(0, left) : right].astype(np.float32)
    if band.shape[0] < 3 or band.shape[1] < 3:
        return 0.0
    return float(np.abs(np.diff(band, axis=0)).mean()) / 255
