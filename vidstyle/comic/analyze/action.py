"""What moves before a still camera: the subject of a shot, found without a model of subjects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate, Foreground
from vidstyle.comic.analyze.saliency import salient_box
from vidstyle.comic.moment import Box

_FEWEST = 4
"""Pictures of a shot that are needed to tell its background."""
_CHANGE, _QUIET = 26.0, 9.5
"""The least difference of a subject from the background, and the most that a still camera's background has on
average, of 255."""
_MOST, _LEAST = 0.25, 0.006
"""The largest usual share of a picture that is subject, above which it is the camera that moves, and the
smallest share at which a shot has a subject."""
_HELD = 0.95
"""The share of a subject that its box holds: it may be in several places."""
_GONE = 0.12
"""A subject is gone where it takes less than this share of its usual place in the shot."""


def with_actions(frames: Sequence[Candidate], shot: Sequence[Candidate]) -> list[Candidate]:
    """Frames of a shot with their action: what differs from the background that most of the shot shows.

    Frames stay as they are where the camera moves, or where nothing does.

    Args:
        frames: to be looked at.
        shot: frames from all of the shot.
    """
    if len(shot) < _FEWEST:
        return list(frames)
    background = np.median([each.thumbnail for each in shot], axis=0).astype(np.float32)
    usual = [_subject(each.thumbnail, background) for each in shot]
    areas = np.array([float((change > 0).mean()) for change, _ in usual])
    most = float(np.percentile(areas, 80))
    if np.median(areas) > _MOST or areas.max() < _LEAST or np.median([rest for _, rest in usual]) > _QUIET:
        return list(frames)
    if most == 0:  # a damaged picture or two among pictures that do not move
        return list(frames)
    changes = [_subject(each.thumbnail, background)[0] for each in frames]
    return [
        replace(each, action=_foreground(each, change, most))
        for each, change in zip(frames, changes, strict=True)
    ]


def unlike(one: Foreground, other: Foreground) -> float:
    """The share of two subjects' places that only one of them takes, 0..1."""
    either = float((one.places | other.places).sum())
    return float((one.places ^ other.places).sum()) / either if either else 0.0


def _subject(thumbnail: np.ndarray, background: np.ndarray) -> tuple[np.ndarray, float]:
    """How a picture differs from the background, 0 where it hardly does, and the mean difference there."""
    color = thumbnail.astype(np.float32)
    # Cameras change their exposure with what they see.
    color *= np.median(background, axis=(0, 1)) / np.maximum(np.median(color, axis=(0, 1)), 1)
    change = cv2.blur(np.abs(color - background).max(axis=2), (3, 3))
    moves = change > _CHANGE
    return np.where(moves, change, 0), float(change[~moves].mean()) if not moves.all() else np.inf


def _foreground(candidate: Candidate, change: np.ndarray, most: float) -> Foreground:
    places = change > 0
    area = float(places.mean())
    edges = (places[0], places[-1], places[:, 0], places[:, -1])
    at_edge = max(float(edge.sum()) for edge in edges) / max(1.0, float(np.sqrt(places.sum())))
    height, width = candidate.shape
    rows, columns = places.shape
    whole = Box[float](0, 0, columns, rows)
    held = salient_box(places.astype(np.float32), _HELD) if area else whole
    box = held.padded(1, 1, 1).intersection(whole)
    across, down = width / columns, height / rows
    inside = Box(box.left * across, box.top * down, box.right * across, box.bottom * down)
    return Foreground(places, inside, min(1.0, area / most), min(1.0, at_edge), area < _GONE * most)
