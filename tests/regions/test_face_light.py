"""Light on dim faces: before a style sees the picture."""

from __future__ import annotations

import numpy as np
from focus import EYES, PLACE, WINDOW
from pictures import picture_with_face

from vidstyle.core.picture import Picture
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.features.face_light import DimFaces, light_faces
from vidstyle.regions.masks import inner_box
from vidstyle.regions.writing.lifting import luma_in

CHEEK = np.s_[66:74, 44:48]
"""A cheek in the window."""


def back_lit(noise: float = 0.0) -> Picture:
    """Return a picture whose face has a quarter of the light, before a white wall."""
    array = 40 + 0.22 * picture_with_face().astype(np.float32)
    array[:, 420:] = 250
    array[:20] = 0
    array += np.random.default_rng(3).normal(0, noise, array.shape) if noise else 0
    return Picture.from_array(np.clip(np.rint(array), 0, 255).astype(np.uint8))


def lit(picture: Picture, *faces: Face) -> Picture:
    return light_faces(picture, DimFaces().follow(picture, faces, None), 1.0)[0]


def test_a_dim_face_gets_light_and_contrast_and_the_rest_none() -> None:
    dim = back_lit()
    before, after = (luma_in(each, WINDOW) for each in (dim, lit(dim, Face(0, PLACE))))
    contrast = [each[CHEEK].mean() / each[EYES].min() for each in (before, after)]
    assert after[CHEEK].mean() > before[CHEEK].mean() and contrast[1] > 1.15 * contrast[0]
    assert np.array_equal(before[:5], after[:5])
    corner = inner_box(PLACE).moved(-WINDOW.left, -WINDOW.top)
    outside = np.s_[round(corner.top) :, round(corner.left) :]
    assert np.array_equal(before[outside][:6, :6], after[outside][:6, :6])


def test_faces_in_light_are_not_dim() -> None:
    bright = Picture.from_array(picture_with_face())
    assert not DimFaces().follow(bright, [Face(0, PLACE)], None)


def test_grain_of_a_dim_face_is_not_raised() -> None:
    dim = back_lit(noise=3)
    before, after = (luma_in(each, WINDOW)[CHEEK] for each in (dim, lit(dim, Face(0, PLACE))))
    assert np.abs(np.diff(after)).mean() < 1.2 * np.abs(np.diff(before)).mean()


def test_a_face_across_the_edge_and_one_outside_change_nothing_else() -> None:
    dim = back_lit()
    faces = [Face(0, PLACE.moved(-310, 0)), Face(1, PLACE.moved(-900, 0))]
    changed = lit(dim, *faces).color != dim.color
    assert changed[:, : PLACE.right - 310 + 10].any() and not changed[:, PLACE.right - 310 + 10 :].any()


def test_light_follows_a_face_smoothly_and_begins_anew_with_others() -> None:
    found, dim = DimFaces(), back_lit()
    bright = Picture.from_array(picture_with_face())
    assert found.follow(dim, [Face(0, PLACE)], 0.0)
    (later,) = found.follow(bright, [Face(0, PLACE)], 0.04)
    assert later.tones[0] > found_tone(dim)
    assert not found.follow(bright, [Face(1, PLACE)], 0.08)


def found_tone(picture: Picture) -> float:
    """Return the median tone of the face."""
    (found,) = DimFaces().follow(picture, [Face(0, PLACE)], None)
    return found.tones[0]
