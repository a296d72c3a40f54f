"""Sideways films without rotation metadata are rotated upright by their faces."""

from __future__ import annotations

import logging
from pathlib import Path

import cv2
import numpy as np
import pytest
from media import photograph
from stories import write_film

from vidstyle.comic.analyze.film import open_film
from vidstyle.comic.analyze.upright import find_turn
from vidstyle.comic.make import ComicOptions, make_comic
from vidstyle.regions.faces import FaceFinder


def person(shift: int = 0) -> np.ndarray:
    """Return the head of the astronaut, 180 x 240 x 3 uint8, moved to the left."""
    return cv2.resize(photograph("astronaut")[20:320, 20 + shift : 420 + shift], (240, 180))


def test_a_film_is_turned_only_if_several_turned_pictures_show_faces() -> None:
    finder = FaceFinder()
    lying = [np.ascontiguousarray(np.rot90(person(shift))) for shift in (0, 16, 0, 16)]
    empty = [np.full((180, 240, 3), 90, np.uint8)] * 2
    assert find_turn([*empty, *lying], finder) == 90
    assert find_turn([np.rot90(each, 2) for each in lying], finder) == 270
    assert find_turn(lying[:2], finder) == 0
    assert find_turn([person(), *lying[:3]], finder) == 0
    assert find_turn([*empty * 4, *lying], finder) == 0
    drawn = [np.ascontiguousarray(each[..., ::-1]) for each in lying]
    assert find_turn(drawn, finder) == 0, "blue faces"


def test_a_comic_of_a_film_on_its_side_is_upright_and_its_page_file_keeps_that(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    frames = [np.ascontiguousarray(np.rot90(person(shift))) for shift in (0, 16) for _ in range(20)]
    film = write_film(tmp_path / "film.mp4", frames)
    options = ComicOptions(styles=("plain",), size="420x600", save=tmp_path / "comic.toml")
    with caplog.at_level(logging.INFO):
        comic = make_comic(film, tmp_path / "page.png", options)
    assert "turned by 90 degrees" in caplog.text and "--rotate 0" in caplog.text
    assert comic.key_frames[0].shape == (180, 240) and comic.key_frames[0].faces
    again = make_comic(tmp_path / "comic.toml", tmp_path / "again.png")
    assert again.files[0].read_bytes() == comic.files[0].read_bytes()
    with open_film(film, rotate=0) as opened:
        opened.survey()
        assert opened.rotate == 0
