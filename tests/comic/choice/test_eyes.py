"""Of the frames near each other, one with open eyes is shown."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from media import photograph
from stories import RATE, write_film

from vidstyle.comic.analyze.faces.eyes import measure_open_eyes
from vidstyle.comic.analyze.faces.face_search import add_faces, with_followed_faces
from vidstyle.comic.analyze.features import extract_features
from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.select.key_frames import KeyFrameOptions, find_key_frames
from vidstyle.regions.boxes import Box
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS

PERSON = cv2.resize(photograph("astronaut")[:360], (640, 450))
EYES = (255, 126), (308, 129)
"""The eyes in that picture."""


def close_eyes(color: np.ndarray) -> np.ndarray:
    """Return a picture of that person with closed eyes."""
    closed = color.copy()
    for across, down in EYES:
        skin = color[down + 22, across].tolist()
        cv2.ellipse(closed, (across, down), (19, 12), 0, 0, 360, skin, -1)
        cv2.line(closed, (across - 14, down + 4), (across + 14, down + 4), (70, 40, 35), 2, cv2.LINE_AA)
    return closed


@pytest.mark.parametrize("turn", [-25, 0, 25])
def test_open_eyes_are_darker_than_a_line(turn: int) -> None:
    """Also if the head is inclined."""
    finder = FaceFinder()
    opened = []
    for picture in (close_eyes(PERSON), PERSON):
        turned = cv2.warpAffine(picture, cv2.getRotationMatrix2D((270, 180), turn, 1), (640, 450))
        face, marks = next(iter(finder.find(turned).items()))
        opened.append(measure_open_eyes(cv2.cvtColor(turned, cv2.COLOR_RGB2GRAY), face, marks))
    assert opened[0] < 0.75 * opened[1]


def test_eyes_beyond_the_edge_of_a_picture_are_measured() -> None:
    luma = cv2.cvtColor(PERSON, cv2.COLOR_RGB2GRAY)
    assert 0 <= measure_open_eyes(luma, Box(-40, 80, 60, 220), USUAL_LANDMARKS) <= 1
    assert measure_open_eyes(luma, Box(600, 440, 700, 600), USUAL_LANDMARKS) == 0


def test_eyes_are_measured_in_frames_to_which_a_face_is_followed() -> None:
    seen, closed = (extract_features(each, 0, (450, 640)) for each in (PERSON, close_eyes(PERSON)))
    seen = add_faces(seen, FaceFinder(), only_large=True)
    followed = with_followed_faces(closed, seen)
    assert len(followed.faces) == 1 and followed.faces[0].center == pytest.approx(seen.faces[0].center, abs=4)
    assert 0 < followed.eyes < 0.75 * seen.eyes
    elsewhere = replace(seen, small=np.ascontiguousarray(seen.small[::-1]))  # type: ignore[index]
    assert not with_followed_faces(elsewhere, replace(seen, small=None)).faces


def test_a_frame_with_open_eyes_is_chosen_though_most_are_closed(tmp_path: Path) -> None:
    """And though the search for faces begins at frames with closed eyes."""
    closed = close_eyes(PERSON)
    random = np.random.default_rng(3)
    noise = random.integers(0, 6, (RATE, *PERSON.shape), np.uint8)
    pictures = [cv2.add(PERSON if 4 <= number < 7 else closed, each) for number, each in enumerate(noise)]
    film = write_film(tmp_path / "blink.mp4", pictures)
    with open_film(film, FaceFinder()) as opened:
        (chosen,) = find_key_frames(opened, KeyFrameOptions(panels=1))
    assert 4 <= round(chosen.time * RATE) < 7
