"""Eyes, nose and mouth of small faces, taken off the source."""

from __future__ import annotations

import av
import cv2
import numpy as np
import pytest
from focus import EYES, PLACE, WINDOW, lifted
from pictures import picture_with_face

from vidstyle.core.picture import Picture
from vidstyle.media.frame import picture_from_frame
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.features import calm_skin
from vidstyle.regions.features.feature_drawing import draw_features
from vidstyle.regions.features.feature_lifting import lift_features
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS
from vidstyle.regions.patches import Patch
from vidstyle.regions.rasters import NO_RASTER
from vidstyle.regions.writing.lifting import luma_in
from vidstyle.style import load_style

pytestmark = pytest.mark.usefixtures("faces_alone")


@pytest.mark.parametrize("format", ["yuv420p", "yuv422p10le", "gray", "rgb24"])
def test_eyes_are_taken_off_every_layout_of_planes(format: str) -> None:
    frame = av.VideoFrame.from_ndarray(picture_with_face(), "rgb24")
    picture = picture_from_frame(frame.reformat(format=format))
    before, (after, (found,)) = luma_in(picture, WINDOW), lifted(picture)
    assert after[EYES].min() > before[EYES].min() + 0.2
    right, down = WINDOW.left - found.window.left, WINDOW.top - found.window.top
    eyes = found.darkness[EYES[0].start + down : EYES[0].stop + down, EYES[1].start + right :]
    assert np.array_equal(before[:20], after[:20]) and eyes.max() > 0.9


def test_grain_is_no_feature(monkeypatch: pytest.MonkeyPatch) -> None:
    """Noise of a dim room would be drawn as specks on forehead and cheeks."""
    noisy = picture_with_face() + np.random.default_rng(5).normal(0, 9, (480, 640, 1))
    picture = Picture.from_array(np.clip(noisy, 0, 255).astype(np.uint8))
    before, (after, (smooth,)) = luma_in(picture, WINDOW), lifted(picture)
    monkeypatch.setattr(calm_skin, "MIN_GRAIN_LUMA", 1.0)
    (grainy,) = lifted(picture)[1]
    steps = [np.abs(np.diff(each.darkness * each.weight)).mean() for each in (smooth, grainy)]
    assert steps[0] < 0.7 * steps[1]
    grains = [np.abs(np.diff(each[EYES], 2)).mean() for each in (before, after)]
    assert grains[1] > 0.4 * grains[0], "skin in place of features lacks the grain around"


def test_features_go_as_far_as_focus() -> None:
    picture = Picture.from_array(picture_with_face())
    before, whole = luma_in(picture, WINDOW), lifted(picture)[0]
    half, (features,) = lifted(picture, 0.5)
    assert np.abs(half - (before + whole) / 2).max() < 0.01
    assert features.amount == 0.5 and lifted(picture, 0.0)[1] == []


def test_features_of_faces_of_any_size_are_alike() -> None:
    """Those of a large face come from a reduced copy."""
    color, shown = picture_with_face(), []
    for factor in (1, 6):
        window, face = (Box(*(factor * side for side in each)) for each in (WINDOW, PLACE))
        large = cv2.resize(color, None, fx=factor, fy=factor, interpolation=cv2.INTER_CUBIC)
        (lifted_face,) = lift_features(Picture.from_array(large), [Patch(window, window, Face(0, face))], 1.0)
        found = lifted_face.features()
        page = Picture.from_array(np.full(large.shape, 200, np.uint8))
        drawn = luma_in(draw_features(page, [found], load_style("poster"), None, NO_RASTER), window)
        assert found.weight.shape[0] <= 350
        shown.append(cv2.resize(drawn, (110, 120), interpolation=cv2.INTER_AREA))
    assert shown[0][EYES].min() < 0.5 and np.corrcoef(shown[0].ravel(), shown[1].ravel())[0, 1] > 0.9


def test_a_strap_is_no_face() -> None:
    """A false face whose eyes are the upper edge of something dark gets no marks."""
    picture = picture_with_face()
    eyes = round(PLACE.top + 0.4 * PLACE.height)
    picture[eyes - 4 :, PLACE.left - 20 : PLACE.right + 20] = 25
    after, found = lifted(Picture.from_array(picture))
    assert found == [] and np.array_equal(after, luma_in(Picture.from_array(picture), WINDOW))


def test_a_dog_is_no_face() -> None:
    """Its nose is darker than its eyes, and its mouth is not where that of a person is."""
    picture, (across, down) = picture_with_face(), USUAL_LANDMARKS.inside(PLACE).nose
    cv2.circle(picture, (round(across), round(down)), 5, (12, 10, 10), -1)
    after, found = lifted(Picture.from_array(picture))
    assert found == [] and np.array_equal(after, luma_in(Picture.from_array(picture), WINDOW))


def face_with_glasses(height: int) -> np.ndarray:
    """Return a picture of a face with two dark lenses, which are twice as high."""
    picture, (middle, _) = picture_with_face(), PLACE.center
    for eye in (round(middle) - 10, round(middle) + 10):
        center = eye, round(PLACE.top + 0.42 * PLACE.height)
        cv2.ellipse(picture, center, (9, height), 0, 0, 360, (20, 20, 24), -1)
    return picture


def test_glasses_down_to_the_cheeks_are_no_strap() -> None:
    assert len(lifted(Picture.from_array(face_with_glasses(13)))[1]) == 1


def test_dark_glasses_are_dark_shapes() -> None:
    """Only their edges would be found in discs of the size of an eye."""
    picture, middle = face_with_glasses(7), round(PLACE.center[0])
    before, (after, (found,)) = (
        luma_in(Picture.from_array(picture), WINDOW),
        lifted(Picture.from_array(picture)),
    )
    left, top = middle + 6, round(PLACE.top + 0.42 * PLACE.height) - 4
    lens, drawn = (
        np.s_[top - each.top : top - each.top + 8, left - each.left : left - each.left + 8]
        for each in (WINDOW, found.window)
    )
    assert (after - before)[lens].mean() > 0.1 and found.darkness[drawn].mean() > 0.5


def test_landmarks_are_found_and_move_with_the_face() -> None:
    """Mirrored, left and right are exchanged."""
    picture = picture_with_face()
    for shown in (picture, np.ascontiguousarray(picture[:, ::-1])):
        ((box, marks),) = FaceFinder().find(shown).items()
        assert marks.left_eye[0] < marks.nose[0] < marks.right_eye[0]
        assert max(marks.left_eye[1], marks.right_eye[1]) < marks.nose[1] < marks.mouth_left[1]
        moved = marks.inside(box.moved(5, 7))
        assert np.allclose(np.array(moved) - np.array(marks.inside(box)), (5, 7))
