"""Panels that tell nothing new are removed: twins, further views of a place, and murk."""

from __future__ import annotations

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from media import photograph
from stories import PLACES, view

from vidstyle.comic.analyze.features import Candidate, extract_features
from vidstyle.comic.analyze.moving.action import Foreground
from vidstyle.comic.select.prune import prune
from vidstyle.comic.select.usable import usable_candidates
from vidstyle.regions.boxes import Box

HALL = view(PLACES[2], 0, 0, (320, 180))
"""A picture without a subject."""


def key_frame(picture: np.ndarray, time: float, **values: object) -> Candidate:
    found = extract_features(picture, time, picture.shape[:2])
    return replace(found, **{"importance": 0.5, "clarity": 1.0} | values)  # type: ignore[arg-type]


def person(time: float, shift: int, size: float = 1.0, **values: object) -> Candidate:
    """A woman before a wall, further to the right by pixels, in a size of shot."""
    still = cv2.resize(photograph("astronaut"), None, fx=size, fy=size)[:180]
    color = np.full((180, 320 + abs(shift), 3), (70, 90, 110), np.uint8)
    left = 40 + shift
    still = still[:, : min(still.shape[1], color.shape[1] - left)]
    color[: len(still), left : left + still.shape[1]] = still
    # The face of that photograph, 512 x 512.
    face = Box(175, 65, 275, 200).scaled(size).moved(left, 0)
    return key_frame(color[:, :320], time, faces=(face,), **values)


def test_a_person_comes_back_only_in_another_size_of_shot() -> None:
    one, turned, close = person(0, 0, 0.5), person(3, 50, 0.5, importance=0.4), person(6, 20, 0.8)
    assert prune([one, turned, close], 0) == [one, close]
    assert prune([one, turned, close], 3) == [one, turned, close]
    requested = replace(turned, forced=True)
    assert prune([one, requested, close], 0) == [requested, close]


def test_one_pose_in_two_framings_and_one_moment_come_once() -> None:
    wide, near = (person(3 * turn, 0, 0.5, framing=name) for turn, name in enumerate(("wide", "near")))
    assert len(prune([wide, near], 0)) == 1
    bowed = replace(near, thumbnail=np.ascontiguousarray(near.thumbnail[::-1]))
    assert len(prune([wide, bowed], 0)) == 2
    moving = Foreground(np.ones((32, 48), bool), Box(60, 40, 200, 130), 1.0, 0.0, False)
    moments = [
        key_frame(
            view(PLACES[number], 0, 0, (320, 180)), time, action=moving, importance=0.5 - 0.1 * (number == 1)
        )
        for number, time in enumerate((0, 0.7, 4))
    ]
    assert [each.time for each in prune(moments, 0)] == [0, 4]
    crowded = [replace(each, time=time) for each, time in zip(moments, (0, 0.7, 1.4), strict=True)]
    crowded[1] = replace(crowded[1], importance=0.9)
    assert [each.time for each in prune(crowded, 0)] == [0, 1.4]
    assert prune([replace(each, scene=number) for number, each in enumerate(moments)], 0)[1].time == 0.7


def test_other_people_in_other_places_stay() -> None:
    one = person(0, 0, 0.5)
    other = key_frame(view(PLACES[3], 0, 0, (320, 180)), 3, faces=(Box(100, 40, 160, 110),))
    assert prune([one, other], 0) == [one, other]


@pytest.mark.parametrize(("seconds", "count"), [(0.4, 1), (3, 4)])
def test_a_place_without_a_subject_has_one_panel_or_the_way_of_a_camera(seconds: float, count: int) -> None:
    views = [
        key_frame(np.roll(HALL, 50 * step, axis=1), step * seconds, importance=1 - step / 9)
        for step in range(5)
    ]
    assert len(prune(views, 0)) == count
    assert len(prune(views, 4)) == 4


def test_one_view_of_a_place_is_kept_next_to_subjects() -> None:
    places = np.zeros((32, 48), bool)
    places[8:24, 10:30] = True
    moving = Foreground(places, Box(60, 40, 200, 130), 1.0, 0.0, False)
    subject = key_frame(view(PLACES[3], 0, 0, (320, 180)), 0, action=moving)
    views = [key_frame(np.roll(HALL, 12 * step, axis=1), 1 + step) for step in range(3)]
    assert len(prune([subject, *views], 0)) == 2


def with_slopes(candidate: Candidate, levels: float, sharpness: float = 0.2) -> Candidate:
    return replace(candidate, detail=np.full((2, 2, 9, 16), levels, np.float16), sharpness=sharpness)


def test_clutter_and_soft_pictures_are_removed() -> None:
    """A large face is kept in clutter, and so are the last four panels."""
    calm = [
        with_slopes(key_frame(view(PLACES[number], 0, 0, (320, 180)), number, scene=number), 2)
        for number in range(4)
    ]
    other = key_frame(view(PLACES[4], 0, 0, (320, 180)), 4, scene=4)
    face = replace(other, faces=(Box(100, 20, 200, 140),))
    assert prune([*calm, with_slopes(other, 6)], 0) == calm
    assert len(prune([*calm, with_slopes(face, 6)], 0)) == 5
    assert len(prune([with_slopes(each, 6) for each in (*calm, other)], 0)) == 4
    soft = with_slopes(other, 2, sharpness=0.1)
    assert prune([*calm, soft], 0) == calm
    walker = Foreground(np.eye(32, 48, dtype=bool), Box(60, 40, 200, 130), 1.0, 0.0, False)
    assert len(prune([*calm, replace(soft, action=walker, resolution=300.0)], 0)) == 5
    assert prune([*calm, replace(soft, action=walker, resolution=300.0, motion=0.2)], 0) == calm


def test_there_are_no_more_places_than_people() -> None:
    shown = [
        with_slopes(
            key_frame(
                view(PLACES[number], 0, 0, (320, 180)), number, scene=number, importance=0.4 + number / 20
            ),
            2,
        )
        for number in range(6)
    ]
    people = [replace(each, faces=(Box(9, 9, 19, 21),)) for each in shown]
    assert prune([*people[:2], *shown[2:]], 0) == [*people[:2], *shown[4:]]
    assert len(prune([*people[:3], *shown[3:]], 0)) == 6


@pytest.mark.parametrize(("light", "kept"), [(0.2, 4), (0.8, 5)])
def test_a_dark_panel_without_forms_is_murk(light: float, kept: int) -> None:
    clear = [key_frame(view(PLACES[number], 0, 0, (320, 180)), number, scene=number) for number in range(4)]
    unclear = key_frame(view(PLACES[5], 0, 0, (320, 180)), 4, clarity=0.3, light=light, scene=4)
    assert len(prune([*clear, unclear], 0)) == kept


def test_an_empty_place_that_another_panel_shows_with_somebody_is_removed() -> None:
    room = key_frame(view(PLACES[0], 0, 0, (320, 180)), 0)
    visited = replace(
        key_frame(view(PLACES[0], 9, 0, (320, 180)), 3), faces=(Box(100, 60, 140, 110),), framing="near"
    )
    other = key_frame(view(PLACES[1], 0, 0, (320, 180)), 6, scene=1)
    assert prune([room, visited, other], 0) == [visited, other]
    assert prune([room, other], 0) == [room, other]


@pytest.mark.parametrize(("cut", "kept"), [(0.7, [0]), (0.2, [0, 9])])
def test_a_subject_outside_of_the_picture_is_removed_next_to_a_whole_one(cut: float, kept: list[int]) -> None:
    subjects = [
        Foreground(np.ones((32, 48), bool), Box(60, 40, 200, 130), 1.0, share, False) for share in (0, cut)
    ]
    whole, leaving = (
        key_frame(view(PLACES[number], 0, 0, (320, 180)), 9 * number, action=subject, scene=number)
        for number, subject in enumerate(subjects)
    )
    assert [each.time for each in prune([whole, leaving], 0)] == kept
    assert prune([leaving], 0) == [leaving]


def test_a_person_who_has_moved_before_a_still_camera_is_no_twin() -> None:
    places = np.zeros((2, 32, 48), bool)
    places[0, :, 6:24] = places[1, :, 26:44] = True
    still, moved = (
        person(time, shift, 0.5, action=Foreground(mask, Box(0, 0, 320, 180), 1.0, 0.0, False))
        for time, shift, mask in zip((0, 9), (0, 100), places, strict=True)
    )
    assert prune([still, moved], 0) == [still, moved]
    assert len(prune([replace(each, action=None) for each in (still, moved)], 0)) == 1


def test_a_cut_subject_does_not_replace_another_of_its_moment() -> None:
    """Though it is more important: it would be removed later, and the moment with it."""
    cars = [
        Foreground(np.ones((32, 48), bool), Box(60, 40, 200, 130), 1.0, share, False)
        for share in (0.7, 0.5, 0)
    ]
    shown = [
        key_frame(
            view(PLACES[number], 0, 0, (320, 180)), time, action=cars[number], importance=1 - 0.1 * number
        )
        for number, time in enumerate((0.0, 1.2, 9.0))
    ]
    assert prune(shown, 0) == shown[1:]


@pytest.mark.parametrize(("detail", "is_kept"), [(30.0, True), (3.0, False)])
def test_a_close_up_of_a_sharp_face_is_not_removed_for_its_few_edges(detail: float, is_kept: bool) -> None:
    places = [key_frame(view(PLACES[number], 0, 0, (320, 180)), number, scene=number) for number in range(3)]
    soft = key_frame(HALL, 5, scene=5, sharpness=0.0, faces=(Box(60, 10, 200, 170),), face_detail=detail)
    calm = [*(with_slopes(each, 2) for each in places), with_slopes(soft, 2, sharpness=0.05)]
    assert (calm[3] in prune(calm, 0)) == (calm[3] in prune([calm[0], calm[3]], 0)) == is_kept


@pytest.mark.parametrize(("resolution", "is_kept"), [(150, False), (215, True), (230, True)])
def test_a_picture_out_of_focus_is_removed_next_to_a_sharp_one(resolution: float, is_kept: bool) -> None:
    """The second value is too near to the other picture, the third one is enough for a small panel."""
    sharp, soft = (
        key_frame(view(PLACES[number], 0, 0, (320, 180)), 9 * number, resolution=value, scene=number)
        for number, value in enumerate((300.0 if resolution != 230 else 900.0, resolution))
    )
    assert (soft in prune([sharp, soft], 0)) == is_kept
    assert prune([replace(soft, forced=True), sharp], 0)[1:] == [sharp]
    assert prune([soft, replace(sharp, resolution=math.inf)], 0)[:1] == [soft]
    assert len(prune([soft, replace(soft, time=99, scene=9, thumbnail=sharp.thumbnail)], 0)) == 2


def test_a_place_that_tells_nothing_is_removed_if_four_panels_are_left() -> None:
    one, *places, dull = (
        key_frame(view(PLACES[number], 0, 0, (320, 180)), 9 * number, importance=value, scene=number)
        for number, value in enumerate((0.9, 0.3, 0.3, 0.3, 0.05))
    )
    someone = replace(one, faces=(Box(100, 40, 160, 110),))
    assert prune([someone, *places, dull], 0) == [someone, *places]
    assert prune([someone, *places[:2], dull], 0) == [someone, *places[:2], dull]


def test_a_view_comes_once_though_the_camera_pans_and_cars_pass() -> None:
    """The more important frame stays; a single large mover that has moved tells something new."""
    picture = cv2.resize(photograph("coffee"), (640, 400))
    panned = [key_frame(picture[30:, left : left + 560], left) for left in (0, 60)]
    shown = [panned[0], replace(panned[1], importance=0.6)]
    assert prune(shown, 0) == shown[1:]
    for several, level, count in ((False, 250, 2), (True, 130, 1)):
        actions = []
        for left in (4, 30):
            places = np.zeros((32, 48), bool)
            places[6:28, left : left + 8] = True
            places[31, 2:46:4] = several
            actions.append(Foreground(places, Box(100, 60, 200, 300), 0.8, 0.0, False))
        movers = [
            replace(each, action=action, time=4.0 * number, thumbnail=_paint(each.thumbnail, action, level))
            for number, (each, action) in enumerate(zip(panned, actions, strict=True))
        ]
        assert len(prune(movers, 0)) == count


def _paint(thumbnail: np.ndarray, action: Foreground, level: int) -> np.ndarray:
    """Draw the movers in a gray level."""
    return np.where(action.places[..., np.newaxis], np.uint8(level), thumbnail)


def test_a_view_that_comes_back_in_another_scene_is_shown_once() -> None:
    hall = cv2.resize(photograph("coffee"), (640, 400))
    first, again = (key_frame(hall[30:, left : left + 560], 9.0 * left, scene=left) for left in (0, 20))
    other = key_frame(view(PLACES[1], 0, 0, (320, 180)), 90, scene=1)
    assert prune([first, other, replace(again, importance=0.6)], 0) == [
        other,
        replace(again, importance=0.6),
    ]


def test_frames_with_reported_errors_are_shown_only_if_no_frame_is_visibly_damaged() -> None:
    frames = [replace(key_frame(view(PLACES[0], 0, 0, (320, 180)), each), damaged=True) for each in (0, 1)]
    assert usable_candidates(frames) == frames
    assert usable_candidates([frames[0], replace(frames[1], broken=True)]) == []


def test_a_dark_picture_without_a_face_is_removed_next_to_lit_ones() -> None:
    """If enough others are left to tell the story."""
    places = [key_frame(view(PLACES[each], 0, 0, (320, 180)), each, scene=each) for each in range(5)]
    moving = Foreground(np.ones((32, 48), bool), Box(60, 40, 200, 130), 1.0, 0.0, False)
    lit = [replace(each, action=moving, light=0.5) for each in places]
    few = [replace(lit[0], light=0.2, clarity=0.45), *lit[1:4]]
    assert prune(few, 0) == few
    dark = [replace(each, light=0.2, clarity=0.45) for each in lit]
    assert prune([dark[0], *lit[1:]], 0) == lit[1:]
    assert prune(dark, 0) == dark


def test_a_short_film_shows_who_has_come_and_what_is_approached() -> None:
    """One picture alone tells no story; within two seconds, nothing has happened."""
    places = np.zeros((32, 48), bool)
    places[8:24, 10:30] = True
    moving = Foreground(places, Box(60, 40, 200, 130), 1.0, 0.0, False)
    empty, come = key_frame(HALL, 0), key_frame(np.roll(HALL, 50, axis=1), 3, action=moving)
    assert prune([empty, come], 0) == [empty, come]
    assert [each.time for each in prune([empty, replace(come, time=1)], 0)] == [1]
    wide, near = key_frame(HALL, 0, framing="wide"), key_frame(HALL, 3, framing="near", importance=0.6)
    assert prune([wide, near], 0) == [wide, near]
    assert len(prune([wide, replace(near, time=1)], 0)) == 1
