"""Empty parts above and below what a picture shows are not printed."""

from __future__ import annotations

import numpy as np

from vidstyle.comic.analyze.empty_margins import find_content, trim
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.regions.boxes import Box


def skyline(sky: int) -> np.ndarray:
    """Return a picture of 480 x 400 with houses below a sky of some rows, H x W x 3 uint8."""
    picture = np.full((480, 400, 3), 200, np.uint8)
    picture[:sky] += np.linspace(0, 30, sky).astype(np.uint8)[:, None, None]
    picture[sky:, ::2] = 40
    picture[sky:].reshape(480 - sky, 20, 20, 3)[:, ::2] = 90
    return picture


def test_an_empty_sky_is_cut_except_for_some_room() -> None:
    content = find_content(skyline(180))
    assert 130 < content.top < 150 and content.bottom == 480 and content.width == 400


def test_little_sky_an_empty_picture_and_an_extreme_shape_stay_whole() -> None:
    for picture in (skyline(70), np.full((480, 400, 3), 90, np.uint8), skyline(180)[170:300]):
        assert find_content(picture) == Box(0, 0, *picture.shape[1::-1])
    assert find_content(np.zeros((1, 1, 3), np.uint8)) == Box(0, 0, 1, 1)


def test_a_trimmed_key_frame_shows_the_same_things_and_keeps_its_subject() -> None:
    picture, subject = skyline(180), Box(50, 100, 90, 200)
    key_frame = KeyFrame(0.0, (480, 400), 1.0, Box(50, 300, 90, 400), (), 0, offset=(3, 20))
    trimmed = trim(key_frame, find_content(picture))
    frame = np.zeros((520, 406, 3), np.uint8)
    frame[20:500, 3:403] = picture
    assert trimmed.trimmed == 480 - trimmed.shape[0] > 100
    assert np.array_equal(trimmed.picture(frame), picture[trimmed.trimmed :])
    assert trimmed.saliency == key_frame.saliency.moved(0, -trimmed.trimmed)
    moving = KeyFrame(0.0, (480, 400), 1.0, subject, (), 0, subject=subject)
    assert trim(moving, find_content(picture)).subject == Box(50, 0, 90, 100)
    face = KeyFrame(0.0, (480, 400), 1.0, subject, (subject,), 0)
    assert trim(face, find_content(picture)) is face


def test_black_ground_is_cut() -> None:
    shore = skyline(0)
    shore[300:] //= 4
    assert 300 < find_content(shore).bottom < 400
