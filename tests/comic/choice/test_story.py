"""A page shows beginning, middle and end, and people who speak with an open mouth."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from media import photograph

from vidstyle.comic.analyze.faces.mouths import measure_open_mouth
from vidstyle.comic.analyze.features import Candidate, extract_features
from vidstyle.comic.analyze.moving.poses import has_other_pose
from vidstyle.comic.select.best_path import find_best_path
from vidstyle.comic.select.film_thirds import film_thirds
from vidstyle.comic.select.frame_scores import scores
from vidstyle.regions.boxes import Box

FACE = Box(40, 20, 140, 150)
"""The face in `speaker`."""


def speaker(opening: float) -> np.ndarray:
    """A face with a mouth that is open by this share of the face, H x W uint8."""
    luma = np.full((180, 180), 60, np.uint8)
    cv2.ellipse(luma, (90, 85), (48, 65), 0, 0, 360, 190, -1)
    cv2.line(luma, (70, 116), (110, 116), 140, 2)
    if opening:
        cv2.ellipse(luma, (90, 118), (16, round(opening * FACE.height)), 0, 0, 360, 30, -1)
    return luma


def key_frame(time: float, **values: object) -> Candidate:
    found = extract_features(photograph("astronaut")[:320, :480], time, (320, 480))
    return replace(found, faces=(Box(170, 60, 275, 200),), **values)  # type: ignore[arg-type]


def test_an_open_mouth_is_dark_between_the_lips() -> None:
    closed, ajar, wide = (measure_open_mouth(speaker(each), FACE, (90, 116)) for each in (0, 0.03, 0.08))
    assert closed == 0 and 0.2 < ajar <= wide == 1


def test_a_mouth_beyond_the_edge_of_a_picture_is_measured() -> None:
    assert measure_open_mouth(speaker(0), Box(150, 150, 260, 290), (205, 250)) >= 0
    assert measure_open_mouth(speaker(0), Box(190, 190, 290, 320), (240, 280)) == 0


def test_a_mouth_that_has_opened_is_another_pose_of_the_same_scene() -> None:
    closed, wide = key_frame(0), key_frame(5, open_mouth=1.0)
    assert has_other_pose(closed, wide)
    assert not has_other_pose(closed, replace(wide, scene=1))
    assert not has_other_pose(closed, replace(wide, open_mouth=0.3))
    assert scores([closed, wide], np.ones(1)).argmax() == 1


@pytest.mark.parametrize("best", [0, 1, 2])
def test_each_third_of_a_film_is_shown(best: int) -> None:
    """Though one of them has all of the better frames."""
    thirds = np.repeat([0, 1, 2], 5)
    values, steps = 1.0 * (thirds == best), np.where(np.triu(np.ones((15, 15)), 1), 0, -np.inf)
    places, prices = np.linspace(0, 1, 15), np.zeros((15, 15))
    assert set(thirds[find_best_path(values, steps, prices, places, 4, thirds)]) == {0, 1, 2}
    assert len(set(thirds[find_best_path(values, steps, prices, places, 4)])) < 3


def test_a_short_film_has_one_part() -> None:
    frames = [key_frame(time) for time in (0, 1, 2, 2.9)]
    assert film_thirds(frames, 2.9) == [0] * 4
    assert film_thirds(frames, 3) == [0, 1, 2, 2]
