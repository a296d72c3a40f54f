"""Moments of one shot: a mover that is near only briefly, a camera that travels, and light that changes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from media import photograph
from stories import PLACES, RATE, view, write_film

from vidstyle.comic.analyze.features import Candidate, Foreground, Survey, extract_features
from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.moving.action import add_actions
from vidstyle.comic.analyze.similarity import compare_views
from vidstyle.comic.select.choose import choose
from vidstyle.comic.select.key_frames import find_key_frames
from vidstyle.comic.select.movers import shows_largest_mover
from vidstyle.comic.select.prune import prune
from vidstyle.comic.select.refinement import _keep_subject
from vidstyle.regions.boxes import Box

ROAD = view(PLACES[2])
CAR = cv2.resize(photograph("chelsea"), (120, 80))
NEAR_SECONDS = 1.6, 2.0
"""Time at which the car is near, and at which it has passed."""


def passing_car(number: int) -> np.ndarray:
    """A frame of an empty road: a car comes from afar and passes, and dust settles for seconds."""
    time, picture = number / RATE, ROAD.copy()
    near, passed = NEAR_SECONDS
    if time < passed:
        scale = 0.12 + 0.88 * (min(time, near) / near) ** 6
        car = cv2.resize(CAR, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        left = 40 + round(150 * max(0.0, time - near))
        picture[130 - len(car) : 130, left : left + car.shape[1]] = car
        return picture
    dust = 0.95 * 0.8 ** (time - passed) * np.clip((110 - np.arange(len(ROAD))) / 30, 0, 1)
    mixed = picture + dust[:, np.newaxis, np.newaxis] * (np.array([215.0, 205, 195]) - picture)
    return np.asarray(np.rint(mixed), np.uint8)


def frames_of(pictures: list[np.ndarray], **values: object) -> list[Candidate]:
    return [
        replace(extract_features(each, 4.0 * number, each.shape[:2]), **values)  # type: ignore[arg-type]
        for number, each in enumerate(pictures)
    ]


def mover(rows: int, cut: float = 0.0) -> Foreground:
    places = np.zeros((32, 48), bool)
    places[8 : 8 + rows, 10:30] = True
    return Foreground(places, Box(60, 40, 200, 130), 1.0, cut, False)


def test_a_car_that_is_near_for_a_moment_is_shown_with_what_follows(tmp_path: Path) -> None:
    path = write_film(tmp_path / "film.mp4", map(passing_car, range(9 * RATE)))
    with open_film(path) as film:
        times = [float(each.time) for each in find_key_frames(film)]
    near, passed = NEAR_SECONDS
    assert len(times) >= 3
    assert any(near - 0.25 <= time < passed for time in times)
    assert sum(time >= passed for time in times) >= 2


def test_light_that_changes_from_edge_to_edge_is_no_subject() -> None:
    """A thing that moves before the same wall is one."""
    lit = ROAD.copy()
    lit[:70] = lit[:70] // 3
    thing = ROAD.copy()
    thing[40:120, 60:180] = CAR
    for changed, is_subject in ((lit, False), (thing, True)):
        shot = frames_of([ROAD] * 12 + [changed] * 5)
        assert any(each.action for each in add_actions(shot, shot)) == is_subject


def test_a_transition_shows_no_subject() -> None:
    """Nor does the rest of its shot lack what the transition shows."""
    mixed = ROAD.copy()
    mixed[20:140, 60:180] = cv2.resize(CAR, (120, 120))
    for in_transition in (False, True):
        shown = frames_of([ROAD] * 6)
        faded = frames_of([mixed] * 3, in_transition=in_transition)
        found = add_actions([*shown, *faded], [*shown, *faded])
        assert [each.action is None for each in found] == [in_transition] * 9


def test_moments_whose_subjects_are_all_cut_off_stay() -> None:
    leaving = mover(20, cut=1.0)
    shown = frames_of([view(PLACES[each]) for each in range(3)], action=leaving, importance=0.5)
    assert prune(shown, 0) == shown
    whole = replace(shown[0], action=mover(20))
    assert prune([whole, *shown[1:]], 0) == [whole]


@pytest.mark.parametrize(("scenes", "count"), [((0, 0), 2), ((0, 1), 2), ((0, 2), 1)])
def test_a_camera_that_approaches_shows_other_moments(scenes: tuple[int, int], count: int) -> None:
    """Also if its travel looks like a dissolve between two scenes, but not after another scene."""
    still = cv2.GaussianBlur(cv2.resize(photograph("rocket"), (960, 540)), (0, 0), 2)
    afar, near = cv2.resize(still, (320, 180)), cv2.resize(still[90:450, 160:800], (320, 180))
    shown = [
        replace(each, scene=scene, importance=0.5)
        for each, scene in zip(frames_of([afar, near]), scenes, strict=True)
    ]
    _, travelled = compare_views([each.thumbnail for each in (*shown, shown[0])])
    assert travelled[0, 1] > 0.6 and travelled[0, 2] == 0
    assert len(prune(shown, 0)) == count


def test_the_largest_mover_is_whole_and_large() -> None:
    wall = frames_of([ROAD] * 4)
    actions = [mover(4), mover(12), mover(20, cut=0.9), None]
    shown = [replace(each, action=action) for each, action in zip(wall, actions, strict=True)]
    assert shows_largest_mover(shown).tolist() == [False, True, False, False]
    person = replace(shown[1], faces=(Box(60, 10, 90, 50),))
    assert not any(shows_largest_mover(each).any() for each in (wall, [person]))
    assert not shows_largest_mover([replace(wall[0], action=mover(1))]).any()


def test_the_largest_mover_is_chosen_though_it_is_brief_and_less_clear() -> None:
    wall = frames_of([ROAD] * 6, clarity=1.0)
    shown = [replace(wall[0], action=mover(4)), *wall[1:]]
    shown[3] = replace(wall[3], action=mover(14), clarity=0.2)
    (found,) = choose(Survey(shown, [0.0], 24.0), [], 1)
    assert found.time == shown[3].time
    assert choose(Survey([shown[0], *wall[1:]], [0.0], 24.0), [], 1)[0].clarity == 1


def test_a_better_frame_shows_the_mover_as_large_or_less_cut_off() -> None:
    near, afar, as_large = (
        replace(each, action=mover(rows))
        for each, rows in zip(frames_of([ROAD] * 3), (20, 6, 18), strict=True)
    )
    assert _keep_subject([afar, as_large], near) == [as_large]
    leaving = replace(near, action=mover(20, cut=0.9))
    assert _keep_subject([afar, as_large], leaving) == [afar, as_large]
