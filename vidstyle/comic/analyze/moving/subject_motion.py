"""The subject that moves against the background while the camera moves, by motion compensation."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate, Foreground
from vidstyle.comic.analyze.moving.action import cut_share
from vidstyle.comic.analyze.similarity import THUMBNAIL_SIZE
from vidstyle.regions.boxes import Box

STEP_SECONDS = 0.16
"""Time between a frame and the frames before and after it with which it is compared."""

# The motion of the camera: an affine transformation with one scale, by tracked corners.
_MAX_CORNERS, _CORNER_QUALITY, _MIN_CORNER_DISTANCE_PX = 120, 0.01, 5
_MIN_TRACKED_CORNERS, _MIN_CAMERA_SHARE = 12, 0.5
"""Number of corners needed, and the share of them that must move with the camera."""

# The subject.
_BLUR_DEVIATION_PX = 1.5
"""Standard deviation of the Gaussian over the change, which removes specks: edges that are not aligned."""
_MIN_CHANGE_LEVELS, _MIN_CHANGE_FACTOR, _CALM_PERCENTILE = 7.0, 3.0, 80
"""Minimum blurred change, of 255, also as a multiple of this percentile: the change of the background."""
_MIN_SUBJECT_SHARE, _MAX_SUBJECT_SHARE = 0.001, 0.3
"""Range of the share of the picture that the subject covers: less is noise, more is parallax."""
_MIN_ENERGY_SHARE = 0.45
"""Minimum share of the change that is in one object; otherwise everything moves."""
_BOX_MARGIN_PX = 2
"""Margin of the box around the subject in the small copy, as only its edges change."""
_WHOLE_MARGIN_RATIO = 0.5
"""Margin of the box around the whole of a tracked subject, whose parts may be still, per longer side."""
_TRACKED_CANDIDATES, _MIN_TRACKED = 3, 3
"""Number of candidates before and after it in which a subject is looked for, and must be found."""
_TRACK_MARGIN_RATIO = 1.0
"""The box of a tracked subject meets the next one if it is enlarged by this multiple of its longer side."""


@dataclass(frozen=True)
class _Frame:
    """A frame in a film: time in seconds and luma, H x W uint8."""

    time: float
    luma: np.ndarray


class SubjectMotion:
    """Finds what moves in the candidates of a film; takes every frame."""

    def __init__(self) -> None:
        self._frames: deque[_Frame] = deque()
        self._waiting: deque[tuple[_Frame, _Frame | None]] = deque()
        self._found: list[np.ndarray | None] = []

    def push(self, time: float, luma: np.ndarray, is_candidate: bool) -> None:
        """Add the next frame: seconds, and a small copy of its luma, H x W float32, 0..1."""
        frame = _Frame(time, cv2.convertScaleAbs(luma, alpha=255))
        while len(self._frames) > 1 and self._frames[1].time <= time - STEP_SECONDS + 1e-3:
            self._frames.popleft()
        while self._waiting and time - self._waiting[0][0].time >= STEP_SECONDS - 1e-3:
            self._resolve(frame)
        if is_candidate:
            self._waiting.append((frame, self._frames[0] if self._frames else None))
        self._frames.append(frame)

    def masks(self) -> list[np.ndarray | None]:
        """Return for each candidate where something moves, H x W bool; None if nothing can be said."""
        while self._waiting:
            self._resolve(None)
        return self._found

    def _resolve(self, after: _Frame | None) -> None:
        frame, before = self._waiting.popleft()
        if before is None or after is None or before.time == frame.time:
            self._found.append(None)
            return
        rests = [_unexplained_change(other.luma, frame.luma) for other in (before, after)]
        first, second = rests
        self._found.append(None if first is None or second is None else _main_object(cv2.min(first, second)))


def _unexplained_change(other: np.ndarray, luma: np.ndarray) -> np.ndarray | None:
    """Return the change from another frame that the camera's motion does not explain, H x W uint8.

    None if the frames do not show the same place.
    """
    if other.shape != luma.shape:
        return None
    corners = cv2.goodFeaturesToTrack(other, _MAX_CORNERS, _CORNER_QUALITY, _MIN_CORNER_DISTANCE_PX)
    if corners is None or len(corners) < _MIN_TRACKED_CORNERS:
        return None
    moved, found, _ = cv2.calcOpticalFlowPyrLK(other, luma, corners, np.empty_like(corners))
    tracked = found.ravel() == 1
    if tracked.sum() < _MIN_TRACKED_CORNERS:
        return None
    camera, inside = cv2.estimateAffinePartial2D(corners[tracked], moved[tracked])
    if camera is None or inside.mean() < _MIN_CAMERA_SHARE:
        return None
    size = luma.shape[1], luma.shape[0]
    warped = cv2.warpAffine(other, camera, size, borderMode=cv2.BORDER_REPLICATE)
    seen = cv2.warpAffine(np.full_like(other, 255), camera, size)
    # Within a pixel, so that edges that are not exactly aligned are no change.
    around = np.ones((3, 3), np.uint8)
    change = cv2.max(
        cv2.subtract(luma, cv2.dilate(warped, around)), cv2.subtract(cv2.erode(warped, around), luma)
    )
    change[cv2.erode(seen, around) < 255] = 0
    return change


def _main_object(change: np.ndarray) -> np.ndarray | None:
    """Return the mask of the object with the most change, H x W bool; None if the change is everywhere."""
    blurred = cv2.GaussianBlur(change.astype(np.float32), (0, 0), _BLUR_DEVIATION_PX)
    calm = _MIN_CHANGE_FACTOR * float(np.percentile(blurred, _CALM_PERCENTILE))
    strong = blurred > max(_MIN_CHANGE_LEVELS, calm)
    count, labels = cv2.connectedComponents(strong.astype(np.uint8), connectivity=8)
    if count < 2:
        return None
    energies = np.bincount(labels.ravel(), (blurred**2).ravel())[1:]
    if energies.max() < _MIN_ENERGY_SHARE * energies.sum():
        return None
    return labels == 1 + int(energies.argmax())


def add_moving_subjects(
    candidates: Sequence[Candidate], masks: Sequence[np.ndarray | None]
) -> list[Candidate]:
    """Return the candidates of a shot with the subject that moves in them, if it is tracked.

    A subject counts only if it is found near its place in most of the candidates before and after it.
    Candidates that have an action already are returned unchanged.

    Args:
        candidates: of one shot, in the order of time.
        masks: where something moves in each, see `SubjectMotion`.
    """
    found = [_subject(each, mask) for each, mask in zip(candidates, masks, strict=True)]
    areas = [float(each.places.mean()) for each in found if each]
    most = max(areas, default=1.0)
    return [
        _track(each, subject, min(1.0, float(subject.places.mean()) / most))
        if subject and each.action is None and sum(_meets(subject, other) for other in near) >= _MIN_TRACKED
        else each
        for each, subject, near in zip(candidates, found, _neighbours(found), strict=True)
    ]


def follow_subject(
    subject: Foreground, frames: Sequence[Candidate], masks: Sequence[np.ndarray | None]
) -> list[Candidate]:
    """Return the frames shortly before and after a candidate in which its tracked subject is found.

    Args:
        subject: of the candidate.
        frames: of the same shot.
        masks: where something moves in each, see `SubjectMotion`.
    """
    found = [_subject(each, mask) for each, mask in zip(frames, masks, strict=True)]
    return [
        _track(each, other, subject.share)
        for each, other in zip(frames, found, strict=True)
        if other and _meets(subject, other)
    ]


def _track(candidate: Candidate, subject: Foreground, share: float) -> Candidate:
    """Return a candidate with its tracked subject, in a box that contains the whole of it."""
    height, width = candidate.shape
    margin = _WHOLE_MARGIN_RATIO * max(subject.box.width, subject.box.height)
    box = subject.box.padded(margin, margin, margin).intersection(Box(0, 0, width, height))
    return replace(candidate, action=subject._replace(box=box, share=share))


def _neighbours(found: Sequence[Foreground | None]) -> Iterator[tuple[Foreground | None, ...]]:
    """Yield the subjects shortly before and after each one."""
    for number in range(len(found)):
        yield (
            *found[max(0, number - _TRACKED_CANDIDATES) : number],
            *found[number + 1 :][:_TRACKED_CANDIDATES],
        )


def _meets(subject: Foreground, other: Foreground | None) -> bool:
    if other is None:
        return False
    margin = _TRACK_MARGIN_RATIO * max(other.box.width, other.box.height)
    return subject.box.intersection(other.box.padded(margin, margin, margin)).area > 0


def _subject(candidate: Candidate, mask: np.ndarray | None) -> Foreground | None:
    """Return what moves in a candidate; None if it is not one compact object."""
    if mask is None:
        return None
    shown = _within_picture(mask, candidate)
    share = float(shown.mean())
    if not _MIN_SUBJECT_SHARE <= share <= _MAX_SUBJECT_SHARE:
        return None
    height, width = candidate.shape
    whole = Box[float](0, 0, shown.shape[1], shown.shape[0])
    rows, columns = (np.flatnonzero(shown.any(axis=axis)) for axis in (1, 0))
    held = Box[float](columns[0], rows[0], columns[-1] + 1, rows[-1] + 1)
    held = held.padded(_BOX_MARGIN_PX, _BOX_MARGIN_PX, _BOX_MARGIN_PX).intersection(whole)
    across, down = width / shown.shape[1], height / shown.shape[0]
    box = Box(held.left * across, held.top * down, held.right * across, held.bottom * down)
    places = cv2.resize(shown.astype(np.uint8), THUMBNAIL_SIZE, interpolation=cv2.INTER_AREA) > 0
    return Foreground(places, box, 1.0, cut_share(shown), is_gone=False)


def _within_picture(mask: np.ndarray, candidate: Candidate) -> np.ndarray:
    """Return the part of a frame's mask within the letterbox bars, which are the same on both sides."""
    (left, top), (height, width) = candidate.offset, candidate.shape
    row, column = (
        round(len(mask) * top / (height + 2 * top)),
        round(mask.shape[1] * left / (width + 2 * left)),
    )
    return mask[row : len(mask) - row, column : mask.shape[1] - column]
