"""Ink in faces: thin strokes are solid, soft shadows are hatched."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from vidstyle.core.picture import Picture
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.features import ink_marks
from vidstyle.regions.features.feature_drawing import draw_features
from vidstyle.regions.features.feature_lifting import lift_features
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS
from vidstyle.regions.features.screens import ShadeScreen
from vidstyle.regions.patches import Patch
from vidstyle.regions.rasters import NO_RASTER
from vidstyle.regions.writing.lifting import luma_in
from vidstyle.style import load_style

HEIGHT = 200
FACE: Box[float] = Box(60, 40, 210, 40 + HEIGHT)
WINDOW = Box(0, 0, 270, 280)
MARKS = USUAL_LANDMARKS.inside(FACE)
NOSE_SIDE = round(MARKS.nose[0]) + 26, round(MARKS.nose[1]) + 4
MIDDLE = USUAL_LANDMARKS.mouth(FACE)
MOUTH = round(MIDDLE[0]), round(MIDDLE[1])
BEARD = MOUTH[0], MOUTH[1] - 14


def drawn_in_ink(shadow_depth: float = 0.5, has_beard: bool = False) -> np.ndarray:
    """Return the luma of a face with eyes, a thin mouth and a soft shadow beside the nose, in ink."""
    luma = np.full((WINDOW.height, WINDOW.width), 190, np.float32)
    for eye in MARKS[:2]:
        cv2.ellipse(luma, (round(eye[0]), round(eye[1])), (14, 6), 0, 0, 360, 40, -1)
    shadow = np.zeros_like(luma)
    cv2.ellipse(shadow, NOSE_SIDE, (9, 26), 0, 0, 360, 1, -1)
    luma *= 1 - shadow_depth * cv2.GaussianBlur(shadow, (0, 0), 5)
    if has_beard:
        cv2.ellipse(luma, BEARD, (34, 12), 0, 0, 360, 15, -1)
    cv2.line(luma, (MOUTH[0] - 20, MOUTH[1]), (MOUTH[0] + 20, MOUTH[1]), 60, 3)
    picture = Picture.from_array(np.dstack([luma.astype(np.uint8)] * 3))
    features = [
        each.features() for each in lift_features(picture, [Patch(WINDOW, WINDOW, Face(0, FACE))], 1.0)
    ]
    page = Picture.from_array(np.full((*luma.shape, 3), 245, np.uint8))
    return luma_in(draw_features(page, features, load_style("ink"), None, NO_RASTER), WINDOW)


def around(page: np.ndarray, point: tuple[int, int], across: int, down: int) -> np.ndarray:
    """Return the part of a page up to these distances from a point."""
    return page[point[1] - down : point[1] + down + 1, point[0] - across : point[0] + across + 1]


def test_thin_strokes_are_solid_and_soft_shadows_are_hatched(monkeypatch: pytest.MonkeyPatch) -> None:
    page = drawn_in_ink()
    shadow, mouth = around(page, NOSE_SIDE, 5, 12), around(page, MOUTH, 14, 0)
    assert mouth.max() < 0.3, "the line between the lips is not solid"
    assert 0.4 < shadow.mean() < 0.9, "a soft shadow is not shade"
    assert (shadow > 0.8).mean() > 0.2, "a soft shadow leaves no paper"
    monkeypatch.setattr(ink_marks, "MAX_SHADE", 0.0)
    assert np.abs(around(drawn_in_ink(), MOUTH, 14, 0) - mouth).max() < 0.05


@pytest.mark.parametrize("is_dotted", [False, True])
def test_screens_print_every_shade_and_stay_on_the_page(is_dotted: bool) -> None:
    """No shade is paper and full shade is ink; between them there is ink in proportion."""
    shades = np.linspace(0, 1, 9, dtype=np.float32)
    screen = ShadeScreen(Box(0, 0, 60, 60), 160, is_dotted=is_dotted)
    inked = [screen.inked(np.full((60, 60), shade, np.float32)).mean() for shade in shades]
    assert inked[0] == 0 and inked[-1] == 1 and (np.diff(inked) > 0).all()
    assert np.abs(inked[4] - 0.5) < 0.1
    whole, part = (
        ShadeScreen(Box(60 - side, 60 - side, 60, 60), 160, is_dotted=is_dotted).inked(
            np.full((side, side), 0.5, np.float32)
        )
        for side in (60, 40)
    )
    assert np.allclose(whole[20:, 20:], part, atol=1e-3)


def test_dark_shade_is_hatched_twice() -> None:
    """The lines of the first set are equal along their direction."""
    screen = ShadeScreen(Box(0, 0, 60, 60), 160, is_dotted=False)
    light, dark = (screen.inked(np.full((60, 60), shade, np.float32)) for shade in (0.5, 0.8))
    differences = [np.abs(each[1:, :-1] - each[:-1, 1:]).max() for each in (light, dark)]
    assert differences[0] < 1e-3 and differences[1] > 0.2


def test_shadows_and_beards_are_never_black() -> None:
    """Black blots turn a smile into a sneer; eyes and the line of the mouth stay black."""
    page, eye = drawn_in_ink(shadow_depth=0.9), (round(MARKS.left_eye[0]), round(MARKS.left_eye[1]))
    assert around(page, (NOSE_SIDE[0], NOSE_SIDE[1] + 5), 4, 6).mean() > 0.62
    assert around(page, eye, 8, 2).mean() < 0.35 and around(page, MOUTH, 14, 0).max() < 0.3
    assert around(drawn_in_ink(has_beard=True), BEARD, 18, 3).mean() > 0.58
