"""The moving subject in front of a still camera, found by background subtraction without an object model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import cv2
import numpy as np

from vidstyle.comic.analyze.features import Candidate, Foreground
from vidstyle.comic.analyze.saliency import salient_box
from vidstyle.regions.boxes import Box

# What counts as the subject of a shot with a still camera.
_MIN_SHOT_FRAMES, _MAX_SHOT_FRAMES = 4, 240
"""Number of frames of a shot needed to estimate its background, and the number from which it is estimated."""
_EMPTY_FRAMES_SHARE = 0.2
"""Share of the frames of a shot, the most typical ones, that show the background if most do not."""
_MAX_TYPICAL_FRAMES = 24
"""Maximum number of frames among which the most typical one is looked for."""
_EXPOSURE_OFFSET_LEVELS = 4.0
"""Added to both levels of a ratio, so that it is stable in the dark."""
_MIN_CHANGE_LEVELS = 26.0
"""Minimum difference between subject and background, of 255."""
_MAX_BACKGROUND_LEVELS = 8.45
"""Maximum mean difference of the background between frames of a still camera, of 255."""
_MAX_USUAL_SUBJECT_SHARE = 0.25
"""Maximum median share of the picture that the subject covers; if it is larger, the camera moves."""
_MIN_SUBJECT_SHARE, _MAX_SUBJECT_SHARE = 0.006, 0.45
"""Minimum share of the picture that the subject covers in at least one frame, and maximum share in any: what
covers more is another place, or hides the subject."""
_MIN_LARGE_CHANGE_RATIO, _LARGE_CHANGE_PERCENTILE = 0.75, 90
"""A change is large from this fraction of the area that this percentile of the frames has: a person who
sways before the place where she rests changes up to half of it."""
_MIN_OFTEN_SHARE, _MIN_CONTOUR_RATIO = 0.5, 1.3
"""Share of the frames with a large change in which a place has changed, and how much stronger edges around
these places are in the picture that shows the subject."""
_SUBJECT_BOX_SHARE = 0.95
"""Share of the subject that its box contains; the subject may be in several places."""
_TOP_EDGE_FACTOR = 2.0
"""How much more a cut by the upper edge counts than one by another edge: it takes the head."""
_GONE_SUBJECT_RATIO = 0.12
"""The subject is gone if it covers less than this fraction of its usual area in the shot."""
_MIN_SPANNING_SHARE = 0.5
"""What changes is light or weather, and no subject, if it reaches from the left to the right edge in more
than this share of the frames that show it."""


def add_actions(frames: Sequence[Candidate], shot: Sequence[Candidate]) -> list[Candidate]:
    """Return frames of a shot with their action: the part that differs from the shot's background.

    Frames are returned unchanged if the camera moves, or if nothing moves.

    Args:
        frames: the frames to analyse.
        shot: frames from the whole shot; those that show a transition tell nothing about it.
    """
    steady = [each for each in shot if not each.in_transition]
    shot = steady if len(steady) >= _MIN_SHOT_FRAMES else shot
    if len(shot) < _MIN_SHOT_FRAMES:
        return list(frames)
    shown = [each.thumbnail.astype(np.float32) for each in shot[:: -(-len(shot) // _MAX_SHOT_FRAMES)]]
    background, usual = _remove_resting_subject(shown, *_find_background(shown))
    areas = np.array([float((change > 0).mean()) for change, _ in usual])
    most = float(np.percentile(areas, 80))
    if (
        np.median(areas) > _MAX_USUAL_SUBJECT_SHARE
        or areas.max() < _MIN_SUBJECT_SHARE
        or np.median([rest for _, rest in usual]) > _MAX_BACKGROUND_LEVELS
    ):
        return list(frames)
    if most == 0:  # a damaged picture or two among pictures that do not move
        return list(frames)
    if _is_light([change > 0 for change, _ in usual], most):
        return list(frames)
    changes = [_subject(each.thumbnail, background)[0] for each in frames]
    return [
        replace(each, action=_foreground(each, change, most))
        if (change > 0).mean() <= _MAX_SUBJECT_SHARE and not each.in_transition
        else each
        for each, change in zip(frames, changes, strict=True)
    ]


def _is_light(masks: Sequence[np.ndarray], most: float) -> bool:
    """Whether what changes in a shot reaches from the left to the right edge whenever it is there."""
    shown = [mask for mask in masks if mask.mean() >= _GONE_SUBJECT_RATIO * most]
    spanning = [bool(mask[:, 0].any() and mask[:, -1].any()) for mask in shown]
    return sum(spanning) > _MIN_SPANNING_SHARE * len(shown)


def _find_background(frames: Sequence[np.ndarray]) -> tuple[np.ndarray, list[tuple[np.ndarray, float]]]:
    """Return the background of a shot, H x W x 3 float32, and the result of `_subject` for each frame.

    It is the median of the frames, or of those that look most like the most typical one, whichever differs
    less from the frames: a person who stays at one place most of the time is no background.
    """
    background = np.median(frames, axis=0)
    matched = np.stack([each / _exposure(each, background) for each in frames])
    apart = _differing_shares(matched)
    emptiest = np.argsort(apart, kind="stable")[: math.ceil(_EMPTY_FRAMES_SHARE * len(frames))]
    tried = [np.median(each, axis=0) for each in (matched, matched[emptiest])]
    found = [(each, [_subject(frame, each) for frame in frames]) for each in tried]
    return min(found, key=lambda each: sum(float((change > 0).mean()) for change, _ in each[1]))


def _remove_resting_subject(
    frames: Sequence[np.ndarray], background: np.ndarray, found: list[tuple[np.ndarray, float]]
) -> tuple[np.ndarray, list[tuple[np.ndarray, float]]]:
    """Return background and subjects after removing a subject that rests in most frames.

    What differs from the background is then the empty place. A subject has a contour, where the empty
    picture has none.
    """
    areas = np.array([float((change > 0).mean()) for change, _ in found])
    large = _MIN_LARGE_CHANGE_RATIO * np.percentile(areas, _LARGE_CHANGE_PERCENTILE)
    changed = [number for number, area in enumerate(areas) if area > large]
    if areas.max() < _MIN_SUBJECT_SHARE or not changed:
        return background, found
    places = np.mean([found[number][0] > 0 for number in changed], axis=0) > _MIN_OFTEN_SHARE
    other = np.median([frames[number] / _exposure(frames[number], background) for number in changed], axis=0)
    around = cv2.dilate(places.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    contour = around & (cv2.erode(places.astype(np.uint8), np.ones((3, 3), np.uint8)) == 0)
    if not contour.any() or _slope_at(background, contour) < _MIN_CONTOUR_RATIO * _slope_at(other, contour):
        return background, found
    empty = np.where(around[..., np.newaxis], other, background)
    return empty, [_subject(frame, empty) for frame in frames]


def _slope_at(color: np.ndarray, places: np.ndarray) -> float:
    """Return the mean slope of a picture, H x W x 3, at some places."""
    luma = color.astype(np.float32).mean(axis=2)
    slopes = np.hypot(cv2.Sobel(luma, cv2.CV_32F, 1, 0), cv2.Sobel(luma, cv2.CV_32F, 0, 1))
    return float(slopes[places].mean())


def _differing_shares(matched: np.ndarray) -> np.ndarray:
    """Return by which share of its area each picture differs from the most typical one.

    That is the one among regularly chosen ones with the least difference from the others.
    """
    small = np.stack(
        [cv2.resize(each, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA) for each in matched]
    )
    tried = small[:: -(-len(small) // _MAX_TYPICAL_FRAMES)]
    apart = [(np.abs(small - each).max(axis=3) > _MIN_CHANGE_LEVELS).mean(axis=(1, 2)) for each in tried]
    return min(apart, key=lambda each: float(each.sum()))


def _exposure(color: np.ndarray, background: np.ndarray) -> np.ndarray:
    """Return by how much each channel of a picture is lighter than the background, which a subject covers."""
    ratios = (color + _EXPOSURE_OFFSET_LEVELS) / (background + _EXPOSURE_OFFSET_LEVELS)
    return np.median(ratios, axis=(0, 1)).astype(np.float32)


def _subject(color: np.ndarray, background: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the difference of a picture from the background, 0 where small, and the mean of the rest."""
    # Automatic exposure changes with the scene.
    matched = color.astype(np.float32) / np.maximum(_exposure(color, background), 1e-3)
    change = cv2.blur(np.abs(matched - background).max(axis=2).astype(np.float32), (3, 3))
    moves = change > _MIN_CHANGE_LEVELS
    return np.where(moves, change, 0), float(change[~moves].mean()) if not moves.all() else np.inf


def _foreground(candidate: Candidate, change: np.ndarray, most: float) -> Foreground:
    places = change > 0
    area = float(places.mean())
    at_edge = cut_share(places)
    height, width = candidate.shape
    rows, columns = places.shape
    whole = Box[float](0, 0, columns, rows)
    held = salient_box(places.astype(np.float32), _SUBJECT_BOX_SHARE) if area else whole
    box = held.padded(1, 1, 1).intersection(whole)
    across, down = width / columns, height / rows
    inside = Box(box.left * across, box.top * down, box.right * across, box.bottom * down)
    return Foreground(places, inside, min(1.0, area / most), at_edge, area < _GONE_SUBJECT_RATIO * most)


def cut_share(places: np.ndarray) -> float:
    """Return how much of a subject with this mask, H x W bool, the picture's edges cut off, 0..1."""
    top, *others = (float(edge.sum()) for edge in (places[0], places[-1], places[:, 0], places[:, -1]))
    longest = max(_TOP_EDGE_FACTOR * top, *others)
    return min(1.0, longest / max(1.0, float(np.sqrt(places.sum()))))
