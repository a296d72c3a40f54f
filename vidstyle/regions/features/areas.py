"""Where the eyes and the mouth are in a face."""

from __future__ import annotations

import numpy as np

from vidstyle.regions.boxes import Point, Rectangle
from vidstyle.regions.face_tracks import Face

EYES_RADIUS_RATIO, MOUTH_RADIUS_RATIO, NOSE_RADIUS_RATIO = 0.2, 0.14, 0.24
"""Distances from the line between the eyes, from the mouth and from the line between both, relative to the
face's height, up to which features belong to them: with brows and glasses; with folds next to the nose."""
EDGE_RANGE = 1.2, 0.7
"""Distances at which an area ends, and up to which it is whole, relative to these."""


def feature_areas(face: Face, window: Rectangle) -> tuple[np.ndarray, np.ndarray]:
    """Return soft masks of eyes and mouth, and of these and the nose, in a window, H x W float32, 0..1."""
    marks, height = face.landmarks.inside(face.box), face.box.height
    lines = (
        (marks.left_eye, marks.right_eye, EYES_RADIUS_RATIO),
        (marks.mouth_left, marks.mouth_right, MOUTH_RADIUS_RATIO),
        (
            _middle(marks.left_eye, marks.right_eye),
            _middle(marks.mouth_left, marks.mouth_right),
            NOSE_RADIUS_RATIO,
        ),
    )
    eyes, mouth, nose = (_near(start, end, ratio * height, window) for start, end, ratio in lines)
    both = np.maximum(eyes, mouth)
    return both, np.maximum(both, nose)


def _middle(one: Point, other: Point) -> Point:
    return (one[0] + other[0]) / 2, (one[1] + other[1]) / 2


def _near(start: Point, end: Point, radius: float, window: Rectangle) -> np.ndarray:
    """Return a soft mask of the pixels near the line between two points, H x W float32, 0..1."""
    none, whole = EDGE_RANGE
    distance = _distance(start, end, window) / np.float32(radius)
    ramp = np.clip((np.float32(none) - distance) / np.float32(none - whole), 0, 1)
    return np.asarray(ramp * ramp * (3 - 2 * ramp), np.float32)


def _distance(start: Point, end: Point, window: Rectangle) -> np.ndarray:
    """Return the distance of each pixel of a window from the line between two points, H x W float32."""
    columns = np.arange(window.left, window.right, dtype=np.float32) + np.float32(0.5 - start[0])
    rows = np.arange(window.top, window.bottom, dtype=np.float32)[:, None] + np.float32(0.5 - start[1])
    across, down = np.float32(end[0] - start[0]), np.float32(end[1] - start[1])
    share = np.clip((columns * across + rows * down) / max(float(across**2 + down**2), 1e-6), 0, 1)
    return np.hypot(columns - share * across, rows - share * down)
