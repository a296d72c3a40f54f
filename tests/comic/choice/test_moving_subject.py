"""A moving subject is compared with itself in other frames: its sharpness and its pose."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from media import photograph

from vidstyle.comic.analyze.features import Candidate, extract_features
from vidstyle.comic.analyze.moving.action import add_actions
from vidstyle.comic.analyze.moving.poses import MIN_POSE_CHANGE, pose_changes
from vidstyle.comic.analyze.moving.subject_sharpness import compare_subjects

WALL = cv2.resize(photograph("coffee"), (640, 360)) // 4 + 120
CAT = cv2.resize(photograph("chelsea"), (180, 120))


def place(left: int, smear: int = 1, cat: np.ndarray = CAT) -> np.ndarray:
    """A cat before a wall, smeared across by pixels."""
    picture = WALL.copy()
    picture[200 : 200 + len(cat), left : left + cat.shape[1]] = cv2.blur(cat, (smear, 1))
    return picture


def find_subjects(pictures: list[np.ndarray]) -> list[Candidate]:
    """Return frames of a shot with a still camera, which begins and ends without the subject."""
    shown = [WALL] * 4 + pictures + [WALL] * 4
    shot = [extract_features(each, number, each.shape[:2]) for number, each in enumerate(shown)]
    return add_actions(shot, shot)[4:-4]


@pytest.mark.parametrize(("smear", "is_smeared"), [(1, False), (25, True)])
def test_a_smeared_subject_before_a_sharp_background_is_blurred(smear: int, is_smeared: bool) -> None:
    pictures = [place(40 + 90 * number, smear if number == 2 else 1) for number in range(5)]
    compared, sharpest = compare_subjects(find_subjects(pictures))
    assert [each.blurred for each in compared] == [is_smeared and number == 2 for number in range(5)]
    assert (compared[2].sharp_subject < 0.7) == is_smeared
    assert sharpest[0] > 0.3


def test_of_two_movers_the_smeared_one_counts() -> None:
    pictures = [place(40 + 20 * number) for number in range(5)]
    for number, each in enumerate(pictures):
        each[60:180, 400:580] = cv2.blur(CAT[:, ::-1], (25, 1)) if number == 2 else CAT[:, ::-1]
    compared, _ = compare_subjects(find_subjects(pictures))
    ratios = [each.sharp_subject for each in compared]
    assert ratios[2] < 0.8 and min(ratios[:2] + ratios[3:]) > 0.95


def test_few_frames_are_not_compared() -> None:
    compared, sharpest = compare_subjects(find_subjects([place(40), place(200, 25)]))
    assert sharpest == {0: 0.0} and not any(each.blurred for each in compared)


def test_a_change_of_most_of_the_picture_is_no_subject() -> None:
    cat, other = find_subjects([place(100), cv2.resize(photograph("astronaut"), WALL.shape[1::-1])])
    assert cat.action is not None and other.action is None


def test_another_pose_is_another_moment() -> None:
    """Not a subject that hardly moves, nor a change of the whole picture, nor another scene."""
    other = cv2.resize(photograph("astronaut")[:340], (180, 120))
    still, near, turned, gone = find_subjects([place(100), place(104), place(100, cat=other), place(400)])
    changes = pose_changes([still, near, turned, gone])[0]
    assert changes[0] == 0 and changes[1] < MIN_POSE_CHANGE <= min(changes[2], changes[3])
    darker = replace(turned, thumbnail=turned.thumbnail // 3)
    assert pose_changes([still, darker])[0, 1] < MIN_POSE_CHANGE
    assert pose_changes([still, replace(turned, scene=1), replace(turned, action=None)])[0].max() == 0
