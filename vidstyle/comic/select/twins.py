"""Twins: two frames that show the same picture, or the same person in the same pose."""

from __future__ import annotations

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.moving.poses import has_other_pose
from vidstyle.comic.analyze.similarity import color_similarity
from vidstyle.regions.boxes import Box

# Twins: the same picture or person again on a page, in the same size of shot.
_TWIN_SIMILARITY = 0.7
"""Similarity, reduced by moved subjects, from which two panels of one framing are twins."""
_MIN_TWIN_FACE_RATIO, _MAX_TWIN_SIZE_RATIO = 0.12, 1.4
"""Minimum height of a face that tells a person, relative to the picture's, and maximum ratio of two."""
_MIN_PERSON_SIMILARITY, _MIN_ROOM_SIMILARITY = 0.5, 0.15
"""Minimum histogram intersection of two views of a person, and minimum similarity of the pictures.

They were tuned on the 27 pairs of people on three pages of trailers: other people of similar colours are in
pictures with a similarity up to 0.11.
"""
_BODY_MARGIN_RATIOS = 0.5, 0.4, 1.5
"""Margins of a person around the face, in heights of the face: at each side, above and below."""

# The pose of a person: head and arms.
_POSE_MARGIN_RATIOS, _POSE_SIDE_PX, _MAX_POSE_SHIFT_PX = (1.2, 0.5, 2.2), 40, 5
"""Margins around the face like those above, side of the compared copies, and the maximum shift."""
_MIN_POSE_CORRELATION, _MIN_SAME_POSE_CORRELATION = 0.62, 0.92
"""Minimum correlation of two views of a person, and the one from which only the framing differs.

They were tuned on 13 pairs on pages that judges had seen: other poses of one person have up to 0.9, and other
shots up to 0.59.
"""


def is_twin(one: Candidate, other: Candidate, like: float) -> bool:
    """Whether two frames show the same in the same framing; `like`: their similarity."""
    if one.framing != other.framing:
        return _has_one_size(one, other) and pose_correlation(one, other) > _MIN_SAME_POSE_CORRELATION
    return like > _TWIN_SIMILARITY or (like >= _MIN_ROOM_SIMILARITY and _is_same_shot_of_person(one, other))


def _is_same_shot_of_person(one: Candidate, other: Candidate) -> bool:
    if not _has_one_size(one, other) or has_other_pose(one, other):
        return False
    is_alike = color_similarity(_person(one), _person(other)) >= _MIN_PERSON_SIMILARITY
    return is_alike or is_same_pose(one, other)


def is_same_pose(one: Candidate, other: Candidate) -> bool:
    """Whether two frames of a scene show a person in the same pose and in the same size."""
    return (
        one.scene == other.scene
        and _has_one_size(one, other)
        and not has_other_pose(one, other)
        and pose_correlation(one, other) > _MIN_POSE_CORRELATION
    )


def _has_one_size(one: Candidate, other: Candidate) -> bool:
    """Whether two frames show a person, in about the same size."""
    sizes = [each.faces[0].height / each.shape[0] if each.faces else 0.0 for each in (one, other)]
    return min(sizes) >= _MIN_TWIN_FACE_RATIO and max(sizes) <= _MAX_TWIN_SIZE_RATIO * min(sizes)


def pose_correlation(one: Candidate, other: Candidate) -> float:
    """Return the correlation of the main persons of two frames after alignment, -1..1."""
    first, second = (_pose(each) for each in (one, other))
    inner = slice(_MAX_POSE_SHIFT_PX, _POSE_SIDE_PX - _MAX_POSE_SHIFT_PX)
    found = cv2.matchTemplate(first, np.ascontiguousarray(second[inner, inner]), cv2.TM_CCOEFF_NORMED)
    return float(found.max())


def _pose(candidate: Candidate) -> np.ndarray:
    """Return head and arms of the main person in a copy of a fixed size, in Lab, H x W x 3 float32."""
    (height, width), (rows, columns) = candidate.shape, candidate.thumbnail.shape[:2]
    face = candidate.faces[0]
    left, top, right, bottom = face.padded(*(ratio * face.height for ratio in _POSE_MARGIN_RATIOS))
    scale = np.array([[columns / width], [rows / height]]) / _POSE_SIDE_PX
    placed = np.array([[right - left, 0, _POSE_SIDE_PX * left], [0, bottom - top, _POSE_SIDE_PX * top]])
    lab = cv2.cvtColor(candidate.thumbnail, cv2.COLOR_RGB2LAB).astype(np.float32)
    return cv2.warpAffine(
        *(lab, placed * scale, (_POSE_SIDE_PX, _POSE_SIDE_PX)),
        flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
        borderMode=cv2.BORDER_REPLICATE,
    )


def _person(candidate: Candidate) -> np.ndarray:
    """Return the part of the thumbnail that shows head and body of the main face, H x W x 3 uint8."""
    (height, width), (rows, columns) = candidate.shape, candidate.thumbnail.shape[:2]
    face = candidate.faces[0]
    body = face.padded(*(ratio * face.height for ratio in _BODY_MARGIN_RATIOS))
    shown = body.intersection(Box(0, 0, width, height))
    top, bottom = int(shown.top * rows / height), int(np.ceil(shown.bottom * rows / height))
    left, right = int(shown.left * columns / width), int(np.ceil(shown.right * columns / width))
    return np.ascontiguousarray(candidate.thumbnail[top:bottom, left:right])
