"""Frames of which a rectangle was overwritten are damaged; signs and title cards are not."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from stories import PLACES, view

from vidstyle.comic.analyze.features import extract_features
from vidstyle.comic.analyze.flaws.film_defects import FilmDefects
from vidstyle.comic.analyze.flaws.flat_boxes import find_flat_box
from vidstyle.regions.boxes import Box

SIZE = 320, 180


def picture(*boxes: tuple[int, int, int, int], level: int = 255) -> np.ndarray:
    """A view with flat rectangles, H x W x 3 uint8."""
    color = view(PLACES[0], 0, 0, SIZE) // 2 + 80
    for left, top, right, bottom in boxes:
        color[top:bottom, left:right] = level
    return color


def luma(color: np.ndarray) -> np.ndarray:
    return cv2.cvtColor(color, cv2.COLOR_RGB2GRAY)


@pytest.mark.parametrize("level", [0, 255])
def test_a_flat_rectangle_is_found_inside_of_the_picture(level: int) -> None:
    found = find_flat_box(luma(picture((100, 40, 200, 90), level=level)))
    assert found is not None and np.allclose(found, (100, 40, 200, 90), atol=3)
    assert find_flat_box(luma(picture())) is None
    assert find_flat_box(luma(picture((0, 0, 320, 30), level=level))) is None
    assert find_flat_box(np.zeros((1, 1), np.uint8)) is None
    disc = luma(picture())
    cv2.circle(disc, (150, 90), 40, level, -1)
    assert find_flat_box(disc) is None


@pytest.mark.parametrize(("last", "damaged"), [(6, [5]), (9, [])])
def test_only_a_rectangle_that_comes_and_goes_is_damage(last: int, damaged: list[int]) -> None:
    """Frames a quarter of a second apart; the rectangle is in those from the fifth to before the last."""
    plain = extract_features(picture(), 0.0, SIZE[::-1])
    covered = extract_features(picture((100, 40, 200, 90)), 0.0, SIZE[::-1])
    frames = [
        replace(covered if 5 <= number < last else plain, time=number / 4, block_corners=0)
        for number in range(12)
    ]
    film = FilmDefects()
    marked = film.mark_all(frames)
    assert [number for number, each in enumerate(marked) if each.damaged] == damaged
    assert film.mark(replace(covered, time=1.29, block_corners=0)).damaged == bool(damaged)


def test_a_single_picture_with_a_rectangle_is_not_damaged() -> None:
    covered = extract_features(picture((100, 40, 200, 90)), 0.0, SIZE[::-1])
    assert covered.flat_box is not None and covered.flat_box.intersection(Box(100, 40, 200, 90)).area > 4000
    assert not FilmDefects().mark_all([covered])[0].damaged
