"""Poses of the moving subject in front of a still camera: how much of it looks different in two frames."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.similarity import THUMBNAIL_SIZE

_SIZE_PX = THUMBNAIL_SIZE[0] // 2, THUMBNAIL_SIZE[1] // 2
"""Width and height of the copies that are compared."""
_MIN_CHANGE_LEVELS = 22
"""Largest difference of the channels in Lab, of 255, from which a place looks different."""
_FULL_CHANGE_SHARE = 0.03
"""Share of the picture that two subjects cover together from which their difference counts fully."""
MIN_POSE_CHANGE = 0.42
"""Change from which the pose, or the person, is another one.

It was tuned on 33 frames of three films: of two figures before a wall, of an animal and of a man who talks.
Frames of one pose have up to 0.35.
"""


_MIN_FACE_RATIO, _MIN_MOUTH_CHANGE = 0.2, 0.5
"""Height of a face, relative to the picture's, whose mouth is seen; and change of a mouth, 0..1, from which
the face has another expression."""


def pose_changes(frames: Sequence[Candidate]) -> np.ndarray:
    """Return how different the subjects of two frames of a scene look: N x N float32, 0..1.

    It is the share of the subjects that looks different, lower for small subjects, and if the background
    looks different, too, as the camera moves; or 1 if a person speaks in only one of the frames. It is 0 for
    frames of different scenes.
    """
    return np.maximum(_moved_shares(frames), _mouth_changes(frames))


def _mouth_changes(frames: Sequence[Candidate]) -> np.ndarray:
    """Return 1 for two frames of a scene whose person speaks in only one of them, else 0: N x N float32."""
    scenes = np.array([each.scene for each in frames])
    mouths = np.array([each.open_mouth for each in frames], np.float32)
    seen = np.array(
        [bool(each.faces) and each.faces[0].height >= _MIN_FACE_RATIO * each.shape[0] for each in frames]
    )
    others = np.abs(np.subtract.outer(mouths, mouths)) >= _MIN_MOUTH_CHANGE
    is_one_person = np.equal.outer(scenes, scenes) & np.logical_and.outer(seen, seen)
    return (others & is_one_person).astype(np.float32)


def _moved_shares(frames: Sequence[Candidate]) -> np.ndarray:
    """Return the share of the subjects of two frames of a scene that looks different: N x N float32, 0..1."""
    found = np.zeros((len(frames), len(frames)), np.float32)
    scenes = np.array([each.scene for each in frames])
    with_subject = np.array([each.action is not None for each in frames])
    colors = np.stack([_shrink(cv2.cvtColor(each.thumbnail, cv2.COLOR_RGB2LAB)) for each in frames])
    empty = np.zeros(THUMBNAIL_SIZE[::-1], np.uint8)
    masks = np.stack(
        [_shrink(255 * each.action.places.astype(np.uint8) if each.action else empty) > 64 for each in frames]
    )
    for number in np.flatnonzero(with_subject):
        others = np.flatnonzero(with_subject[:number] & (scenes[:number] == scenes[number]))
        apart = np.abs(colors[others] - colors[number]).max(axis=3) > _MIN_CHANGE_LEVELS
        covered = masks[others] | masks[number]
        inside = (apart & covered).mean(axis=(1, 2)) / np.maximum(
            covered.mean(axis=(1, 2)), _FULL_CHANGE_SHARE
        )
        outside = (apart & ~covered).mean(axis=(1, 2)) / np.maximum((~covered).mean(axis=(1, 2)), 1e-3)
        found[number, others] = found[others, number] = np.maximum(0, inside - outside)
    return found


def _shrink(picture: np.ndarray) -> np.ndarray:
    return cv2.resize(picture, _SIZE_PX, interpolation=cv2.INTER_AREA).astype(np.int16)


def has_other_pose(one: Candidate, other: Candidate) -> bool:
    """Whether the subject of a scene with a still camera looks different in the second frame."""
    return float(pose_changes([one, other])[0, 1]) >= MIN_POSE_CHANGE
