"""Frames that lost detail, subjects that rest in most frames, and noise of compression in small sources."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from media import photograph

from vidstyle.comic.analyze.action import add_actions
from vidstyle.comic.analyze.features import extract_features
from vidstyle.comic.analyze.flaws.defect_limits import DefectLimits
from vidstyle.comic.output.compression_noise import smooth_compression_noise

SHARP = cv2.resize(photograph("chelsea"), (640, 360))


def smeared(across: int, down: int) -> np.ndarray:
    return cv2.blur(SHARP, (across, down))


@pytest.mark.parametrize("blurred", [smeared(15, 1), smeared(1, 15), smeared(7, 7)])
@pytest.mark.parametrize("scene", [0, 1])
def test_a_frame_without_the_detail_of_its_neighbours_is_blurred(blurred: np.ndarray, scene: int) -> None:
    """Also in front of a still camera, and if the sudden blur looked like a cut."""
    sharp = [extract_features(SHARP, time, (360, 640)) for time in (0.0, 0.25, 0.5, 0.75)]
    soft = replace(extract_features(blurred, 1.0, (360, 640)), scene=scene)
    limits = DefectLimits.of([*sharp, soft])
    assert [limits.mark(each).blurred for each in (*sharp, soft)] == [False] * 4 + [True]


def test_other_content_is_not_blurred() -> None:
    frames = [extract_features(SHARP, time, (360, 640)) for time in (0.0, 0.25, 0.5)]
    calm = extract_features(cv2.resize(photograph("rocket"), (640, 360)), 0.75, (360, 640))
    assert not DefectLimits.of([*frames, calm]).mark(replace(calm, scene=1)).blurred


@pytest.mark.parametrize("empty", [3, 7])
def test_a_subject_may_rest_in_most_frames_of_its_shot(empty: int) -> None:
    wall = cv2.resize(photograph("rocket"), (320, 240)) // 4 + 120
    person = wall.copy()
    cv2.ellipse(person, (160, 130), (26, 70), 0, 0, 360, (20, 15, 30), -1)
    pictures = [wall] * empty + [person] * (10 - empty)
    shot = [extract_features(each, time, (240, 320)) for time, each in enumerate(pictures)]
    actions = [each.action for each in add_actions(shot, shot)]
    assert [action is not None and not action.is_gone for action in actions] == [
        time >= empty for time in range(10)
    ]


def test_faint_squares_vanish_and_edges_stay() -> None:
    squares = np.kron(np.indices((12, 16)).sum(axis=0) % 2, np.ones((16, 16), int))[..., np.newaxis]
    picture = (np.full((192, 256, 3), 120) + 6 * squares - 3).astype(np.uint8)
    picture[:, 128:] += 80
    smooth = smooth_compression_noise(picture).astype(int)
    assert smooth[:, :100].std() < 0.5 * picture[:, :100].std()
    assert (smooth[:, 132] - smooth[:, 123]).mean() > 70
