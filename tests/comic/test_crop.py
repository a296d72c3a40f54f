"""Properties of crops."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction

import cv2
import numpy as np
import pytest
from comic_key_frames import LANDSCAPE, PORTRAIT, SQUARE, WIDE, random_film

from vidstyle.comic.analyze.features import add_saliency, extract_features
from vidstyle.comic.analyze.saliency import find_blobs
from vidstyle.comic.key_frame import KeyFrame
from vidstyle.comic.layout.crop import (
    MIN_FACELESS_WINDOW_RATIO,
    MIN_TINY_FACE_WINDOW_RATIO,
    MIN_WINDOW_RATIO,
    add_face_room,
    crop,
    largest_window,
    required_box,
)
from vidstyle.regions.boxes import Box

ASPECTS = (0.45, 0.7, 1.0, 1.4, 1.78, 2.4, 3.2)
KEY_FRAMES = [
    key_frame for seed in range(25) for key_frame in random_film(seed, 4, (LANDSCAPE, PORTRAIT, SQUARE, WIDE))
]
TOLERANCE = 1e-6
MIDDLE = Box(800, 400, 1100, 700)


def is_cut(window: Box, box: Box) -> bool:
    """Whether a part of a box, but not all of it, is in a window."""
    part = window.intersection(box).area / box.area
    return TOLERANCE < part < 1 - TOLERANCE


def is_inside(window: Box, box: Box) -> bool:
    return window.intersection(box).area > (1 - TOLERANCE) * box.area


@pytest.mark.parametrize(("height", "belongs"), [(210, True), (190, False)])
def test_a_panel_shows_a_pair_but_not_a_person_far_behind(height: int, belongs: bool) -> None:
    """A face at least half as high as the main one is required; without faces only the saliency is."""
    main, other = Box(200, 300, 500, 700), Box(1300, 350, 1500, 350 + height)
    key_frame = KeyFrame(0, LANDSCAPE, 0.5, MIDDLE, (main, other), 0)
    kept = required_box(key_frame)
    assert kept.contains(add_face_room(key_frame, main)) and kept.top < main.top
    assert kept.contains(add_face_room(key_frame, other)) == belongs == (kept.right > 1500)
    assert required_box(replace(key_frame, faces=())) == MIDDLE


def large_windows(key_frame: KeyFrame, aspect: float) -> Iterator[Box]:
    """Yield windows of the largest size all over the picture."""
    width, height = largest_window(key_frame, aspect)
    tall, wide = key_frame.shape
    for part in np.linspace(0, 1, 101):
        left, top = part * (wide - width), part * (tall - height)
        yield Box(left, top, left + width, top + height)


def key_frame_with(*faces: Box, saliency: Box = MIDDLE) -> KeyFrame:
    return KeyFrame(Fraction(0), LANDSCAPE, 0.5, saliency, faces, 0)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_a_window_is_in_its_picture_and_has_its_aspect(aspect: float) -> None:
    for key_frame in KEY_FRAMES:
        window = crop(key_frame, aspect)
        height, width = key_frame.shape
        assert 0 <= window.left < window.right <= width
        assert 0 <= window.top < window.bottom <= height
        assert window.width == pytest.approx(aspect * window.height, abs=1e-3)


@pytest.mark.parametrize("aspect", ASPECTS)
def test_saliency_is_shown_and_no_face_cut_if_possible(aspect: float) -> None:
    held = 0
    for key_frame in KEY_FRAMES:
        window = crop(key_frame, aspect)
        for wanted in ([key_frame.saliency, *key_frame.faces[:1]], key_frame.faces[:1]):
            possible = any(
                all(is_inside(other, box) for box in wanted)
                and not any(is_cut(other, face) for face in key_frame.faces)
                for other in large_windows(key_frame, aspect)
            )
            if possible:
                held += 1
                assert all(is_inside(window, box) for box in wanted)
                assert not any(is_cut(window, face) for face in key_frame.faces)
    assert held > len(KEY_FRAMES) / 2


def test_the_main_face_is_whole_even_if_another_one_must_be_cut() -> None:
    large, small = Box(500, 300, 900, 700), Box(880, 300, 1000, 450)
    key_frame = key_frame_with(large, small)
    for aspect in (0.4, 0.5, 1.0, 2.0):
        assert is_inside(crop(key_frame, aspect), large)


def test_a_narrow_panel_omits_a_face_rather_than_cutting_it() -> None:
    main, other = Box(300, 300, 700, 700), Box(1000, 350, 1200, 550)
    window = crop(key_frame_with(main, other, saliency=main), 0.6)
    assert is_inside(window, main)
    assert not is_cut(window, other)


def test_there_is_room_above_a_head() -> None:
    for top in (150, 300, 500):
        face = Box(800, top, 1000, top + 200)
        for aspect in ASPECTS[:-1]:
            assert is_inside(
                crop(key_frame_with(face, saliency=face), aspect), add_face_room(key_frame_with(face), face)
            )


def test_there_is_room_above_a_large_head_in_a_low_panel() -> None:
    face = Box(800, 450, 1100, 800)
    key_frame = key_frame_with(face, saliency=face)
    assert is_inside(crop(key_frame, 3.2), add_face_room(key_frame, face))


def test_the_window_is_smaller_if_every_large_one_cuts_a_face() -> None:
    main, below, right = Box(600, 60, 1000, 400), Box(160, 650, 650, 910), Box(1050, 150, 1500, 400)
    key_frame = key_frame_with(main, below, right, saliency=main)
    assert all(
        any(is_cut(other, face) for face in key_frame.faces) for other in large_windows(key_frame, 1.0)
    )
    window = crop(key_frame, 1.0)
    assert is_inside(window, main)
    assert not any(is_cut(window, face) for face in key_frame.faces)


@pytest.mark.parametrize("middle", [500, 1300])
def test_a_face_is_at_a_third_with_its_eyes_in_the_upper_part(middle: int) -> None:
    face = Box(middle - 100, 350, middle + 100, 600)
    window = crop(key_frame_with(face, saliency=face), 1.5)
    across = (middle - window.left) / window.width
    down = (475 - window.top) / window.height
    assert min(abs(across - 1 / 3), abs(across - 2 / 3)) < 0.05
    assert 0.3 < down < 0.5


def test_a_small_face_is_enlarged_but_not_too_much() -> None:
    sides = {}
    for side in (40, 130, 500):
        face = Box(900, 400, 900 + side, 400 + side)
        sides[side] = crop(key_frame_with(face, saliency=face), 1920 / 1080).width / 1920
    assert sides == pytest.approx({40: MIN_TINY_FACE_WINDOW_RATIO, 130: MIN_WINDOW_RATIO, 500: 1.0}, abs=0.3)
    assert sides[40] < sides[130] < sides[500]


def test_without_a_face_most_of_the_picture_is_shown() -> None:
    for key_frame in KEY_FRAMES:
        for aspect in ASPECTS:
            least = MIN_TINY_FACE_WINDOW_RATIO if key_frame.faces else MIN_FACELESS_WINDOW_RATIO
            assert crop(key_frame, aspect).width > (least - TOLERANCE) * largest_window(key_frame, aspect)[0]


def test_an_empty_picture_can_be_cropped() -> None:
    for saliency in (Box(0, 0, 0, 0), Box(0, 0, 1920, 1080)):
        window = crop(key_frame_with(saliency=saliency), 1.0)
        assert window.width == pytest.approx(window.height)


def test_no_blob_is_cut_if_another_window_cuts_none() -> None:
    """A title at the top, and an object below it that a low window can show instead."""
    title, ball = Box(100, 100, 800, 260), Box(900, 500, 1100, 1000)
    key_frame = replace(key_frame_with(saliency=Box(100, 100, 1700, 1000)), blobs=(title, ball))
    for aspect in (2.2, 2.4, 2.6):
        assert not any(is_cut(crop(key_frame, aspect), blob) for blob in key_frame.blobs)
    assert any(is_cut(crop(replace(key_frame, blobs=()), 2.4), blob) for blob in key_frame.blobs)


def test_blobs_are_found_and_kept_whole() -> None:
    """Balls far from the middle, on a background that gets lighter downwards."""
    ground = np.repeat(np.linspace(60, 140, 360, dtype=np.uint8)[:, None], 640, axis=1)
    picture = np.stack([ground, ground, ground + 20], axis=2)
    balls = [Box(40, 30, 90, 80), Box(560, 290, 600, 330)]
    for ball in balls:
        middle = round((ball.left + ball.right) / 2), round((ball.top + ball.bottom) / 2)
        cv2.circle(picture, middle, round(ball.width / 2), (230, 80, 40), -1, cv2.LINE_AA)
    seen = add_saliency(extract_features(picture, 0, picture.shape[:2]))
    assert len(seen.blobs) == 2
    assert all(any(blob.contains(ball) for blob in seen.blobs) for ball in balls)
    assert all(seen.saliency.contains(ball) for ball in balls)
    assert find_blobs(np.full((90, 160, 3), 90, np.uint8)) == []


def test_the_foot_of_a_salient_figure_is_lost_before_its_head() -> None:
    figure = Box(800, 100, 1000, 1050)
    window = crop(key_frame_with(saliency=figure), 3.2)
    assert not is_inside(window, figure)
    assert window.top <= figure.top


def test_a_moving_subject_is_whole_even_if_it_is_at_the_edge() -> None:
    subject = Box(1500.0, 100.0, 1900.0, 1000.0)
    key_frame = replace(key_frame_with(saliency=subject), subject=subject)
    for aspect in (0.5, 1.0, 1.5):
        assert is_inside(crop(key_frame, aspect), subject)
