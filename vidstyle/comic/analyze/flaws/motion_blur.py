"""Motion blur predicted from the optical flow of each part of a picture, as one part may stand still."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate
from vidstyle.regions.boxes import Box

FLOW_ROWS, FLOW_COLUMNS = 9, 16
"""Size of the grid on which the flow is kept."""
_MAX_EXPOSURE_SECONDS = 1 / 24
"""Longest exposure assumed: films with fewer frames per second are not exposed for longer."""
MAX_PICTURE_FLOW, _MAX_FACE_FLOW = 0.015, 0.018
"""Median flow of a picture and of its largest face above which they are blurred, in widths of the picture.

They were tuned on a trailer of 24 frames per second, on 71 pictures and 43 faces, which were looked at.
"""
_MOVER_FLOW_PERCENTILE = 80
"""Percentile of the flow of a moving subject that represents its fast parts."""
_LIMB_FLOW_PERCENTILE = 97
"""Percentile of the flow of a picture that represents hands."""
_FULL_LIMB_FLOW = 0.012
"""Flow of hands from which they are smears, in widths of the picture.

In a film of a signing person, moving hands have 0.005 to 0.016, resting hands up to 0.002.
"""
_MAX_STILL_FLOW = 0.003
"""Median flow of a picture below which the camera is still."""


class FlowMeter:
    """Measures how far each part of a picture moves during an exposure; takes every frame of a film."""

    def __init__(self) -> None:
        self._before: tuple[float, np.ndarray] | None = None
        self._flow = cv2.DISOpticalFlow.create(cv2.DISOPTICAL_FLOW_PRESET_FAST)

    def push(self, time: float, luma: np.ndarray, is_wanted: bool) -> np.ndarray | None:
        """Add the next frame: seconds, and a small copy of its luma, H x W float32, 0..1.

        Returns:
            Rows x columns float32, in widths of the frame; None if it is not wanted, or no frame of its size
            precedes it.
        """
        picture = cv2.convertScaleAbs(luma, alpha=255)
        before, self._before = self._before, (time, picture)
        if not is_wanted or before is None or before[1].shape != picture.shape or min(picture.shape) < 16:
            return None
        moved = np.linalg.norm(self._flow.calc(before[1], picture, np.empty(0)), axis=2)
        grid = cv2.resize(moved, (FLOW_COLUMNS, FLOW_ROWS), interpolation=cv2.INTER_AREA)
        share = min(1.0, _MAX_EXPOSURE_SECONDS / max(time - before[0], 1e-3))
        return np.asarray(grid * share / picture.shape[1], np.float32)


def region_flow(candidate: Candidate, box: Box | None = None) -> float:
    """Return the median flow of a part of a picture, or of all of it, in widths; 0 if it is not known."""
    if candidate.flow is None:
        return 0.0
    if box is None:
        return float(np.median(candidate.flow))
    (left, top), (height, width) = candidate.offset, candidate.shape
    across, down = FLOW_COLUMNS / (width + 2 * left), FLOW_ROWS / (height + 2 * top)
    rows = slice(int((top + box.top) * down), int((top + box.bottom) * down) + 1)
    columns = slice(int((left + box.left) * across), int((left + box.right) * across) + 1)
    return float(np.median(candidate.flow[rows, columns]))


def subject_flow(candidate: Candidate) -> float:
    """Return the flow of the largest face, or else of the moving subject, or else of the picture."""
    if candidate.faces:
        return region_flow(candidate, candidate.faces[0])
    if candidate.action and not candidate.action.is_gone:
        return _mover_flow(candidate, candidate.action.places)
    return region_flow(candidate)


def _mover_flow(candidate: Candidate, places: np.ndarray) -> float:
    """Return the flow of the fastest parts of a moving subject, without the background; 0 if it is not known.

    `places`: its mask within the black bars, H x W bool.
    """
    if candidate.flow is None:
        return 0.0
    (left, top), (height, width) = candidate.offset, candidate.shape
    rows, columns = places.shape
    aside, above = round(left * columns / width), round(top * rows / height)
    whole = np.pad(places.astype(np.float32), ((above, above), (aside, aside)))
    covered = cv2.resize(whole, (FLOW_COLUMNS, FLOW_ROWS), interpolation=cv2.INTER_AREA)
    return float(np.percentile(candidate.flow[covered >= covered.max() / 2], _MOVER_FLOW_PERCENTILE))


def limb_blur(candidate: Candidate) -> float:
    """Return how much the hands of a person with a face are smeared, 0..1; the face may be still."""
    if candidate.flow is None or not candidate.faces:
        return 0.0
    return min(1.0, float(np.percentile(candidate.flow, _LIMB_FLOW_PERCENTILE)) / _FULL_LIMB_FLOW)


def mark_fast_faces(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Mark the candidates as blurred whose largest face moves fast, or whose hands do before a still camera.

    The background may be sharp.
    """
    return [replace(each, blurred=True) if _is_smeared_person(each) else each for each in candidates]


def _is_smeared_person(candidate: Candidate) -> bool:
    has_smeared_hands = limb_blur(candidate) == 1 and region_flow(candidate) < _MAX_STILL_FLOW
    return bool(candidate.faces) and (subject_flow(candidate) > _MAX_FACE_FLOW or has_smeared_hands)
