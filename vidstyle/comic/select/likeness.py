"""How alike two frames of a film are for a reader: by their pictures, poses, and travels of the camera."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.comic.analyze.moving.poses import MIN_POSE_CHANGE, pose_changes
from vidstyle.comic.analyze.similarity import TRAVEL_WEIGHT, compare_views, similarity

MAX_STORY_SCENES = 3
"""Number of scenes of a film up to which other poses are other moments."""
_MOVED_SUBJECT_WEIGHT, _MOVED_SUBJECT_SCENES_WEIGHT = 0.5, 0.2
"""Subtracted from the similarity of two frames of a scene if the pose or place of the subject differs.

The first value is for films of up to `MAX_STORY_SCENES` scenes.
"""
MAX_SPLIT_SCENES = 1
"""Distance of two scenes that may be one shot, as a travelling camera can look like a dissolve."""


def likeness(pool: Sequence[Candidate], scenes: int, sees_travel: bool = False) -> np.ndarray:
    """Return the similarity of frames, N x N; lower for other poses before a still camera.

    `sees_travel`: whether to use `view_similarity`.
    """
    like = view_similarity(pool) if sees_travel else similarity([each.thumbnail for each in pool])
    weight = _MOVED_SUBJECT_WEIGHT if scenes <= MAX_STORY_SCENES else _MOVED_SUBJECT_SCENES_WEIGHT
    return np.asarray(like - weight * np.minimum(1, pose_changes(pool) / MIN_POSE_CHANGE))


def view_similarity(frames: Sequence[Candidate]) -> np.ndarray:
    """Return the similarity of frames, N x N; lower for places between which the camera of a shot travels.

    People and movers are compared by their poses instead, see `likeness`.
    """
    like, travelled = compare_views([each.thumbnail for each in frames])
    scenes, is_place = (
        np.array([each.scene for each in frames]),
        np.array([not (each.faces or each.action) for each in frames]),
    )
    is_shot = np.abs(np.subtract.outer(scenes, scenes)) <= MAX_SPLIT_SCENES
    return like - TRAVEL_WEIGHT * travelled * (is_shot & np.logical_and.outer(is_place, is_place))
