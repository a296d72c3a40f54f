"""Where the eyes, the nose and the mouth are in a face."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from vidstyle.regions.boxes import Box, Point, Rectangle
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.features.blurring import enlarged
from vidstyle.regions.features.ramps import ramp
from vidstyle.regions.features.windows import reduced_window

EYE_RADIUS_RATIOS, MOUTH_RADIUS_RATIO, NOSE_RADIUS_RATIOS = (0.17, 0.12), 0.1, (0.11, 0.06)
"""Radii of an eye with its brow along and across the line between the eyes, distance from the line between
the corners of the mouth, and radii of the tip of the nose, relative to the face's height."""
BROW_RATIO, NOSTRIL_RATIO = 0.03, 0.03
"""How far the middle of an eye with its brow is above the eye, and nostrils are below the tip of the nose, in
the same way."""
BRIDGE_RADIUS_RATIO, CENTER_RADIUS_RATIO = 0.2, 0.24
"""Distances from the line between the eyes, and from the middle line of the face, within which features lie:
with glasses; with folds next to the nose."""
EDGE_RANGE = 1.25, 0.75
"""Distances at which an area ends, and up to which it is whole, relative to these."""
MAX_MASK_HEIGHT_PX = 64
"""Height of a face from which its masks are enlarged."""
SAMPLE_RADIUS_RATIO, EYE_SHARE = 0.06, 0.25
"""Half the side of the squares in which luma of eyes, cheeks and forehead is compared, relative to the face's
height; and the quantile of luma that counts as the eye."""
EYE_LUMA_RATIO_RANGE, CHEEK_LUMA_RATIO_RANGE = (0.9, 0.97), (0.5, 0.35)
"""Luma of an eye relative to the cheek below, and of that cheek relative to the forehead, from which it is
doubtful, and from which it is certain that there is no eye. On 24 faces and the strap of a watch."""
NOSE_LUMA_RATIO_RANGE = 0.95, 0.8
"""Luma of the nose relative to the darker eye, from which it may be, and from which it is, that of an animal:
0.68 for a dog, 1.0 and more for 46 of 47 people."""
CHEEK_PLACE_RATIOS = 0.5, 0.8
"""Where the luma of a cheek is measured, between an eye and the corner of the mouth on its side."""
MAX_GLASSES_LUMA_RATIO = 0.6
"""Luma of skin without features at both eyes, relative to the cheeks, below which there are dark glasses."""
MIN_LUMA = 0.03
"""Added to luma before it is compared, because of noise."""


class Areas(NamedTuple):
    """Soft masks in the window of a face, H x W float32, 0..1.

    Attributes:
        eyes: eyes with their brows.
        parts: eyes and mouth.
        core: also the tip of the nose, and glasses.
        whole: also folds next to the nose and the mouth.
    """

    eyes: np.ndarray
    parts: np.ndarray
    core: np.ndarray
    whole: np.ndarray


def feature_areas(face: Face, window: Rectangle, eye_factor: float = 1.0) -> Areas:
    """Return where features are in a window; the masks of a large face are computed in a reduced copy.

    Args:
        eye_factor: how much larger than usual eyes are.
    """
    small = _areas(*reduced_window(face, window, MAX_MASK_HEIGHT_PX), eye_factor)
    return Areas(*(enlarged(each, (window.height, window.width)) for each in small))


def _areas(face: Face, window: Rectangle, eye_factor: float) -> Areas:
    marks, height = face.landmarks.inside(face.box), face.box.height
    along = _direction(marks.left_eye, marks.right_eye)
    down = -along[1], along[0]

    def ellipse(center: Point, lower: float, radii: tuple[float, float]) -> np.ndarray:
        across, below = (center[axis] + lower * height * down[axis] for axis in (0, 1))
        return _soft(_distance((across, below), along, window, radii, height))

    def capsule(start: Point, end: Point, ratio: float) -> np.ndarray:
        return _soft(_line_distance(start, end, window) / np.float32(ratio * height))

    along_eye, across_eye = (eye_factor * ratio for ratio in EYE_RADIUS_RATIOS)
    eyes = np.maximum(*(ellipse(eye, -BROW_RATIO, (along_eye, across_eye)) for eye in marks[:2]))
    mouth = capsule(marks.mouth_left, marks.mouth_right, MOUTH_RADIUS_RATIO)
    nose = ellipse(marks.nose, NOSTRIL_RATIO, NOSE_RADIUS_RATIOS)
    both = np.maximum(eyes, mouth)
    core = np.maximum.reduce([both, nose, capsule(*marks[:2], BRIDGE_RADIUS_RATIO)])
    folds = capsule(_middle(*marks[:2]), _middle(*marks[3:]), CENTER_RADIUS_RATIO)
    return Areas(eyes, both, core, np.maximum(core, folds))


def eye_doubt(luma: np.ndarray, face: Face, window: Rectangle) -> float:
    """Return how unlikely it is that a face has eyes, 0..1: an eye is darker than the cheek below it.

    A cheek that is much darker than the forehead, and no eye above it, are a dark edge, such as a strap. A
    nose that is darker than both eyes is that of an animal, whose other features are at other places.

    Args:
        luma: the window, H x W float32, 0..1.
    """
    marks, level = face.landmarks.inside(face.box), _Levels(luma, face, window)
    between = _middle(*marks[:2])
    forehead = level(_toward(between, _middle(*marks[3:]), -0.4), 0.5)
    nose = level(marks.nose, EYE_SHARE) / min(level(eye, EYE_SHARE) for eye in marks[:2])
    doubts = [float(ramp(nose, NOSE_LUMA_RATIO_RANGE))]
    for eye, corner in zip(marks[:2], marks[3:], strict=True):
        cheek = _cheek(level, eye, corner)
        pairs = (
            (level(eye, EYE_SHARE) / cheek, EYE_LUMA_RATIO_RANGE),
            (cheek / forehead, CHEEK_LUMA_RATIO_RANGE),
        )
        doubts.append(min(float(ramp(*pair)) for pair in pairs))
    return max(doubts)


def has_dark_glasses(skin: np.ndarray, face: Face, window: Rectangle) -> bool:
    """Whether a face has something dark and wide over both eyes; `skin`: see `skin_luma`."""
    marks, level = face.landmarks.inside(face.box), _Levels(skin, face, window)
    sides = zip(marks[:2], marks[3:], strict=True)
    return all(level(eye, 0.5) < MAX_GLASSES_LUMA_RATIO * _cheek(level, eye, corner) for eye, corner in sides)


def _cheek(level: _Levels, eye: Point, corner: Point) -> float:
    """Return the luma of a cheek between an eye and a corner of the mouth, or below glasses that hide it."""
    return max(level(_toward(eye, corner, share), 0.5) for share in CHEEK_PLACE_RATIOS)


class _Levels:
    """Quantiles of luma in small squares of a face."""

    def __init__(self, luma: np.ndarray, face: Face, window: Rectangle) -> None:
        self._luma, self._window = luma, window
        self._radius = SAMPLE_RADIUS_RATIO * face.box.height

    def __call__(self, point: Point, share: float) -> float:
        """Return a quantile around a point of the picture."""
        left, top = point[0] - self._window.left, point[1] - self._window.top
        radius, (height, width) = self._radius, self._luma.shape
        ends = left - radius, top - radius, left + radius + 1, top + radius + 1
        inside = Box(*map(round, ends)).intersection(Box(0, 0, width, height))
        samples = np.sort(self._luma[inside.top : inside.bottom, inside.left : inside.right], axis=None)
        return MIN_LUMA + (float(samples[int(share * (samples.size - 1))]) if samples.size else 0.0)


def _toward(start: Point, end: Point, share: float) -> Point:
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


def _direction(start: Point, end: Point) -> Point:
    across, down = end[0] - start[0], end[1] - start[1]
    length = math.hypot(across, down)
    return (across / length, down / length) if length else (1.0, 0.0)


def _middle(one: Point, other: Point) -> Point:
    return (one[0] + other[0]) / 2, (one[1] + other[1]) / 2


def _soft(distance: np.ndarray) -> np.ndarray:
    """Return a soft mask of the pixels up to a relative distance of 1, H x W float32, 0..1."""
    share = ramp(distance, EDGE_RANGE)
    return np.asarray(share * share * (3 - 2 * share), np.float32)


def _offsets(point: Point, window: Rectangle) -> tuple[np.ndarray, np.ndarray]:
    """Return how far pixels of a window are to the right of a point, 1 x W, and below it, H x 1, float32."""
    columns = np.arange(window.left, window.right, dtype=np.float32) + np.float32(0.5 - point[0])
    rows = np.arange(window.top, window.bottom, dtype=np.float32) + np.float32(0.5 - point[1])
    return columns[None], rows[:, None]


def _distance(
    center: Point, along: Point, window: Rectangle, radii: tuple[float, float], height: float
) -> np.ndarray:
    """Return the distance of each pixel from the centre of an ellipse, relative to its edge."""
    columns, rows = _offsets(center, window)
    first = (columns * np.float32(along[0]) + rows * np.float32(along[1])) / np.float32(radii[0] * height)
    other = (rows * np.float32(along[0]) - columns * np.float32(along[1])) / np.float32(radii[1] * height)
    return np.hypot(first, other)


def _line_distance(start: Point, end: Point, window: Rectangle) -> np.ndarray:
    """Return the distance of each pixel of a window from the line between two points, H x W float32."""
    columns, rows = _offsets(start, window)
    across, down = np.float32(end[0] - start[0]), np.float32(end[1] - start[1])
    share = np.clip((columns * across + rows * down) / max(float(across**2 + down**2), 1e-6), 0, 1)
    return np.hypot(columns - share * across, rows - share * down)
