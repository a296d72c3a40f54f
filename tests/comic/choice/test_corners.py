"""Pictures of one view are recognized by their corners, and shown once."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from media import photograph

from vidstyle.comic.analyze.corners import find_corners, show_same_view
from vidstyle.comic.analyze.features import Candidate, Foreground, add_saliency, extract_features
from vidstyle.comic.select.prune import prune
from vidstyle.comic.select.views import find_repeated_view
from vidstyle.regions.boxes import Box

SIZE = 640, 400
ROCKET = cv2.resize(photograph("rocket"), SIZE)


def seen(scale: float, turn: float, across: float, light: float = 1.0) -> np.ndarray:
    """The picture seen from elsewhere, and in other light."""
    place = cv2.getRotationMatrix2D((320, 200), turn, scale) + np.array([[0, 0, across], [0, 0, 0]])
    moved = cv2.warpAffine(ROCKET, place, SIZE, borderMode=cv2.BORDER_REFLECT)
    return np.clip(moved * light, 0, 255).astype(np.uint8)


def gray(color: np.ndarray) -> np.ndarray:
    return color if color.ndim == 2 else cv2.cvtColor(color, cv2.COLOR_RGB2GRAY)


@pytest.mark.parametrize(
    ("other", "is_same"),
    [
        (seen(1.2, 3, 60), True),
        (seen(1.0, 0, 90, light=0.7), True),
        (cv2.resize(photograph("coffee"), SIZE), False),
        (cv2.resize(photograph("brick"), SIZE), False),
        (np.full((400, 640, 3), 90, np.uint8), False),
    ],
)
def test_a_view_is_recognized_from_a_little_aside(other: np.ndarray, is_same: bool) -> None:
    pair = [find_corners(gray(each)) for each in (ROCKET, other)]
    assert show_same_view(*pair) == show_same_view(*pair[::-1]) == is_same
    assert not show_same_view(pair[0], None)


@pytest.mark.parametrize("shape", [(1, 1), (400, 1), (20, 640)])
def test_a_tiny_picture_shows_no_known_view(shape: tuple[int, int]) -> None:
    tiny = find_corners(cv2.resize(gray(ROCKET), shape[::-1]))
    assert len(tiny.places) == 0 and not show_same_view(tiny, tiny)


def key_frame(picture: np.ndarray, time: float, **values: object) -> Candidate:
    found = add_saliency(extract_features(picture, time, picture.shape[:2]))
    return replace(found, **{"importance": 0.5} | values)  # type: ignore[arg-type]


def test_one_view_of_a_slow_camera_is_shown_once() -> None:
    """On a page of two panels, too."""
    frames = [key_frame(seen(1, 0, 0), 0), key_frame(seen(1.2, 4, 90), 4, importance=0.4)]
    assert prune(frames, 0) == frames[:1]
    unknown = [replace(each, corners=None) for each in frames]
    assert prune(unknown, 0) == unknown


def test_of_one_view_the_frame_with_a_mover_is_shown() -> None:
    """Though it is less important."""
    frames = [key_frame(ROCKET, time, importance=0.5 - 0.1 * time) for time in range(2)]
    assert find_repeated_view(frames) == 1
    speck = np.zeros((32, 48), bool)
    speck[8:10, 10:13] = True
    mover = Foreground(speck, Box(60, 40, 100, 60), 1.0, 0.0, False)
    assert find_repeated_view([frames[0], replace(frames[1], action=mover)]) == 0
