"""Eyes, nose and mouth of small faces: taken off the source, and drawn over the result."""

from __future__ import annotations

import av
import numpy as np
import pytest
from pictures import FACE, picture_with_face

from vidstyle.core.picture import Picture
from vidstyle.media.frame import picture_from_frame
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.features import feature_lifting
from vidstyle.regions.features.feature_drawing import draw_features
from vidstyle.regions.features.feature_lifting import FACE_RATIOS, Features, lift_features
from vidstyle.regions.patches import Patch
from vidstyle.regions.rasters import NO_RASTER, PageRaster
from vidstyle.regions.writing.lifting import luma_in
from vidstyle.style import load_style

PLACE = FACE.moved(250, 150)
WINDOW = Box(280, 140, 390, 260)
EYES = np.s_[48:60, 40:64]
"""The eyes in the window."""

pytestmark = pytest.mark.usefixtures("faces_alone")


def lifted(picture: Picture, amount: float = 1.0, side: float = 480.0) -> tuple[np.ndarray, list[Features]]:
    """Return the luma of the window without features, and these."""
    copied = picture.map_planes(lambda plane, _: plane.copy())
    features = lift_features(copied, [Patch(WINDOW, WINDOW, Face(0, PLACE))], amount, side)
    return luma_in(copied, WINDOW), features


@pytest.mark.parametrize("format", ["yuv420p", "yuv422p10le", "gray", "rgb24"])
def test_eyes_are_taken_off_every_layout_of_planes(format: str) -> None:
    frame = av.VideoFrame.from_ndarray(picture_with_face(), "rgb24")
    picture = picture_from_frame(frame.reformat(format=format))
    before, (after, (found,)) = luma_in(picture, WINDOW), lifted(picture)
    assert after[EYES].min() > before[EYES].min() + 0.2
    assert np.array_equal(before[:20], after[:20]) and found.dark[EYES].max() == 1


def test_grain_is_no_feature(monkeypatch: pytest.MonkeyPatch) -> None:
    """Noise of a dim room would be drawn as specks on forehead and cheeks."""
    noisy = picture_with_face() + np.random.default_rng(5).normal(0, 9, (480, 640, 1))
    picture = Picture.from_array(np.clip(noisy, 0, 255).astype(np.uint8))
    (smooth,) = lifted(picture)[1]
    monkeypatch.setattr(feature_lifting, "MIN_GRAIN_LUMA", 1.0)
    (grainy,) = lifted(picture)[1]
    steps = [np.abs(np.diff(each.dark * each.weight)).mean() for each in (smooth, grainy)]
    assert steps[0] < 0.7 * steps[1]


def test_features_go_as_far_as_focus_and_the_size_of_a_face() -> None:
    picture = Picture.from_array(picture_with_face())
    before, whole = luma_in(picture, WINDOW), lifted(picture)[0]
    assert np.abs(lifted(picture, 0.5)[0] - (before + whole) / 2).max() < 0.01
    assert lifted(picture, 0.0)[1] == lifted(picture, side=PLACE.height / FACE_RATIOS[1])[1] == []
    (half,) = lifted(picture, side=2 * PLACE.height / sum(FACE_RATIOS))[1]
    assert half.amount == pytest.approx(0.5)


@pytest.mark.parametrize("ground", [40, 190])
def test_light_marks_are_on_skin_alone(ground: int) -> None:
    """Teeth, but not the rim of a dark collar below a bowed head."""
    picture = picture_with_face()
    mouth = picture[PLACE.top + 36 : PLACE.bottom + 6, PLACE.left : PLACE.right]
    mouth[:] = ground
    mouth[6:8, 12:33] = 250
    (found,) = lifted(Picture.from_array(picture))[1]
    assert (found.light[PLACE.top + 40 - found.window.top :].max() > 0.3) == (ground > 100)


@pytest.mark.parametrize(
    ("name", "paper", "is_dark"),
    [("ink", 250, True), ("oil", 180, True), ("blueprint", 90, False), ("neon", 4, False)],
)
def test_eyes_are_drawn_in_the_colours_of_the_style(name: str, paper: int, is_dark: bool) -> None:
    """Light on black, where a style paints light; and nothing around the face changes."""
    features, page = (
        lifted(Picture.from_array(picture_with_face()))[1],
        np.full((480, 640, 3), paper, np.uint8),
    )
    page[:, 357:360] = 220
    drawn = draw_features(Picture.from_array(page), features, load_style(name), None, NO_RASTER)
    change = luma_in(drawn, WINDOW)[EYES] - paper / 255
    assert (change.min() < -0.3) if is_dark else (change.max() > 0.3)
    assert np.array_equal(drawn.color[:150], page[:150]) and np.array_equal(
        drawn.color[:, :290], page[:, :290]
    )


def test_features_keep_to_squares_and_to_the_region_of_a_style() -> None:
    features, page = lifted(Picture.from_array(picture_with_face()))[1], np.full((480, 640, 3), 200, np.uint8)
    style, region = load_style("pixel"), np.zeros((480, 640), np.float32)
    page_picture = Picture.from_array(page)
    drawn = draw_features(page_picture, features, style, None, PageRaster(cell=(2, 2))).color
    inner = drawn[182:212, 318:348].reshape(15, 2, 15, 2, 3)
    assert np.ptp(inner, axis=(1, 3)).max() == 0 and inner.min() < 150
    assert np.array_equal(draw_features(page_picture, features, style, region, NO_RASTER).color, page)


def test_landmarks_are_found_and_move_with_the_face() -> None:
    """Mirrored, left and right are exchanged."""
    picture = picture_with_face()
    for shown in (picture, np.ascontiguousarray(picture[:, ::-1])):
        ((box, marks),) = FaceFinder().find(shown).items()
        assert marks.left_eye[0] < marks.nose[0] < marks.right_eye[0]
        assert max(marks.left_eye[1], marks.right_eye[1]) < marks.nose[1] < marks.mouth_left[1]
        moved = marks.inside(box.moved(5, 7))
        assert np.allclose(np.array(moved) - np.array(marks.inside(box)), (5, 7))
