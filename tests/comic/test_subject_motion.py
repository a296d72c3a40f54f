"""What moves against the background is found though the camera moves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from stories import PLACES, RATE, small_luma, view, write_film

from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.moving.subject_motion import STEP_SECONDS, SubjectMotion

FRAMES = 2 * RATE


def flight(number: int) -> tuple[int, int]:
    """The place of the object in a frame."""
    return 60 + 3 * number, 90 - number


def panning(with_object: bool) -> list[np.ndarray]:
    """A camera that turns over a place, before which a dark disc flies."""
    frames = [view(PLACES[0], 1.5 * number, 0.3 * number) for number in range(FRAMES)]
    if with_object:
        frames = [cv2.circle(each, flight(number), 9, (10, 10, 30), -1) for number, each in enumerate(frames)]
    return frames


def masks_of(frames: list[np.ndarray]) -> list[np.ndarray | None]:
    motion = SubjectMotion()
    for number, frame in enumerate(frames):
        motion.push(number / RATE, small_luma(frame), number % 5 == 0)
    return motion.masks()


def test_a_flying_object_is_the_subject_though_the_camera_turns(tmp_path: Path) -> None:
    with open_film(write_film(tmp_path / "film.mp4", panning(True))) as film:
        found = [each for each in film.survey().candidates if each.action]
    assert len(found) >= 4
    for each in found:
        assert each.action
        x, y = flight(round(each.time * RATE))
        assert each.action.box.padded(4, 4, 4).left <= x <= each.action.box.right + 4
        assert each.action.box.top - 4 <= y <= each.action.box.bottom + 4
        assert each.action.box.width < 120


def test_the_subject_is_found_in_frames_around_a_candidate(tmp_path: Path) -> None:
    with open_film(write_film(tmp_path / "film.mp4", panning(True))) as film:
        candidate = next(each for each in film.survey().candidates if each.action and each.time > 0.7)
        near = film.around(candidate)
        still = film.around(replace(candidate, action=None))
    found = [each for each in near if each.action]
    assert len(found) > 6
    for each in found:
        assert each.action
        x, y = flight(round(each.time * RATE))
        assert each.action.box.left <= x <= each.action.box.right
        assert each.action.box.top <= y <= each.action.box.bottom
    assert not any(each.action for each in still)


def test_a_camera_that_turns_has_no_subject(tmp_path: Path) -> None:
    with open_film(write_film(tmp_path / "film.mp4", panning(False))) as film:
        assert not any(each.action for each in film.survey().candidates)


def test_the_mask_covers_only_the_object() -> None:
    masks = masks_of(panning(True))
    assert len(masks) == FRAMES // 5
    middle = masks[len(masks) // 2]
    assert middle is not None and 0.001 < middle.mean() < 0.08
    assert masks[0] is None  # no frame before it


@pytest.mark.parametrize(
    "frames", [[], [np.zeros((8, 8, 3), np.uint8)], [np.zeros((144, 256, 3), np.uint8)] * 9]
)
def test_few_or_blank_frames_have_no_motion(frames: list[np.ndarray]) -> None:
    assert masks_of(frames) == [None] * -(-len(frames) // 5)
    assert STEP_SECONDS > 0
