"""Focus: faces in finer detail, and nothing else changed."""

from __future__ import annotations

from dataclasses import replace

import av
import cv2
import numpy as np
import pytest
from focus import PLACE, focused_on, planes, without
from media import photograph
from pictures import picture_with_face

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Picture
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.media.frame import picture_from_frame
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import FaceFollower
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.features import feature_lifting, media
from vidstyle.regions.focus import FACE_RATIOS, FocusRenderer
from vidstyle.regions.masks import mask_box
from vidstyle.regions.patches import plane_area
from vidstyle.renderer import open_renderer, stylize
from vidstyle.stabilize.still import flatten_still
from vidstyle.style import load_style, style_from_table

STYLES = ("comic", "engraving", "ink")

pytestmark = pytest.mark.usefixtures("faces_alone")


def likeness(one: np.ndarray, other: np.ndarray) -> float:
    """Return the correlation of eyes and mouth, in luma without structure larger than a pupil."""
    inner, details = PLACE.padded(-0.12 * PLACE.width, 0, 0), []
    rows = [int(PLACE.top + share * PLACE.height) for share in (0.28, 0.5, 0.66, 0.86)]
    for picture in (one, other):
        luma = picture[:, int(inner.left) : int(inner.right)].mean(axis=2)
        luma = cv2.GaussianBlur(luma, (0, 0), 0.7) - cv2.GaussianBlur(luma, (0, 0), 3)
        details.append(np.vstack([luma[rows[0] : rows[1]], luma[rows[2] : rows[3]]]).ravel())
    return float(np.corrcoef(*details)[0, 1])


@pytest.mark.parametrize(
    ("name", "least"),
    [
        ("cartoon", 0.84),
        ("comic", 0.74),
        ("engraving", 0.76),
        ("ink", 0.81),
        ("manga", 0.79),
        ("poster", 0.79),
    ],
)
def test_a_pale_face_keeps_its_features(name: str, least: float) -> None:
    """As by flash. Some styles keep most of them without focus, too, as they expose locally."""
    picture, style = (picture_with_face() * 0.3 + 150).astype(np.uint8), load_style(name)
    assert likeness(picture, stylize(picture, style, "cpu")) > least


def test_much_of_what_a_pale_face_loses_is_there_with_focus() -> None:
    picture, style = (picture_with_face() * 0.3 + 150).astype(np.uint8), load_style("woodcut")
    focused, plain = (likeness(picture, stylize(picture, each, "cpu")) for each in (style, without(style)))
    assert 1 - focused < 0.7 * (1 - plain)


def test_faces_have_smaller_marks() -> None:
    """In squares, a face changes more often from pixel to pixel."""
    table = {"format": 1, "height": 480, "background": [{"block": "pixelate", "size": 8}]}
    picture, style = picture_with_face(), style_from_table(table, "pixels")
    inner = PLACE.padded(-0.2 * PLACE.width, -0.2 * PLACE.height, -0.2 * PLACE.height)
    area = plane_area(Box(*map(round, inner)), (1, 1))
    faces = (focused_on([PLACE], picture, each)[area] for each in (style, without(style)))
    counts = [np.count_nonzero((face[:, 1:] != face[:, :-1]).any(axis=2)) for face in faces]
    assert counts[0] > 1.6 * counts[1]


def test_eyes_in_squares_are_no_bars(monkeypatch: pytest.MonkeyPatch) -> None:
    """A style of squares raises contrast. Nothing is drawn over its colours."""
    picture, style = picture_with_face(), load_style("pixel")
    inner = PLACE.padded(-0.2 * PLACE.width, -0.3 * PLACE.height, 0)
    area = plane_area(Box(*map(round, inner)), (1, 1))
    soft = focused_on([PLACE], picture, style)[area]
    monkeypatch.setattr(media, "POINTS_SHARE", 0.0)
    hard = focused_on([PLACE], picture, style)[area]
    assert soft.std() < 0.95 * hard.std()
    assert len(np.unique(soft.reshape(-1, 3), axis=0)) <= 32


def test_the_drawing_of_faces_in_squares_is_not_prepared(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(feature_lifting, "face_darkness", None)
    focused_on([PLACE], picture_with_face(), load_style("pixel"))
    with pytest.raises(TypeError):
        focused_on([PLACE], picture_with_face(), load_style("poster"))


@pytest.mark.parametrize("name", STYLES)
def test_only_faces_change(name: str) -> None:
    style = load_style(name)
    picture = picture_with_face()
    changed = (stylize(picture, style, "cpu") != stylize(picture, without(style), "cpu")).any(axis=2)
    rows, columns = np.nonzero(changed)
    found = Box(columns.min(), rows.min(), columns.max() + 1, rows.max() + 1)
    assert mask_box(PLACE).padded(8, 8, 8).contains(found) and found.area > PLACE.area


def test_pictures_without_a_small_face_are_unchanged() -> None:
    """Neither tables nor a face that fills the picture."""
    style, astronaut = load_style("comic"), np.ascontiguousarray(photograph("astronaut")[40:300, 80:400])
    for picture in (picture_with_face(None), photograph("rocket"), astronaut):
        assert np.array_equal(stylize(picture, style, "cpu"), stylize(picture, without(style), "cpu"))


def test_a_style_without_height_has_no_focus() -> None:
    picture, style = picture_with_face(), replace(load_style("comic"), height=None)
    assert np.array_equal(stylize(picture, style, "cpu"), stylize(picture, without(style), "cpu"))


def test_focus_is_a_slider() -> None:
    """More of it changes the face more."""
    picture, style = picture_with_face(), load_style("oil")
    results = [stylize(picture, replace(style, focus=focus), "cpu").astype(int) for focus in (0, 0.3, 1)]
    small, large = (np.abs(each - results[0]).mean() for each in results[1:])
    assert 0 < small < large


@pytest.mark.parametrize("format", ["yuv420p", "yuv422p10le", "yuv444p", "gray", "rgb24", "yuva420p"])
def test_every_layout_of_planes(format: str) -> None:
    """The planes outside faces and alpha are those without focus; odd sizes work."""
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture_with_face()[:479, :639]), "rgb24")
    picture, style = picture_from_frame(frame.reformat(format=format)), load_style("comic")
    results = []
    for each in (style, without(style)):
        with FocusRenderer(each, lambda style, _: CpuRenderer(style), FaceFollower(FaceFinder())) as renderer:
            results.append(renderer.run(picture))
    focused, plain = results
    assert focused.encoding == plain.encoding and focused.shape == plain.shape
    for one, other in zip(planes(focused), planes(plain), strict=True):
        assert one.shape == other.shape and one.dtype == other.dtype
        below = 280 * one.shape[0] // 479
        assert np.array_equal(one[below:], other[below:])
    main = [focused.luma, plain.luma] if focused.color is None else [focused.color, plain.color]
    assert main[0] is not None and main[1] is not None and (main[0] != main[1]).any()
    if plain.alpha is not None:
        assert focused.alpha is plain.alpha or np.array_equal(focused.alpha, plain.alpha)


def test_a_change_of_style_takes_effect_on_faces() -> None:
    picture, styles = Picture.from_array(picture_with_face()), [load_style(name) for name in ("comic", "ink")]
    renderer = open_renderer(styles[0], "cpu")
    renderer.run(picture)
    renderer.change_style(styles[1])
    changed = renderer.run(picture, rgb=True).color
    renderer.change_style(without(styles[1]))
    off = renderer.run(picture, rgb=True).color
    renderer.close()
    assert np.array_equal(changed, stylize(picture_with_face(), styles[1], "cpu"))
    assert np.array_equal(off, stylize(picture_with_face(), without(styles[1]), "cpu"))


def test_no_picture_waits_for_faces_that_cannot_be_found(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Without the networks the result has no focus, and a line reports what to install."""
    from vidstyle.regions import faces

    monkeypatch.setattr(faces, "weights_folder", lambda: None)
    picture, style = picture_with_face(), load_style("ink")
    with caplog.at_level("INFO", "vidstyle"):
        result = stylize(picture, style, "cpu")
    (line,) = [record.message for record in caplog.records if "focus" in record.message]
    assert "vidstyle[comic]" in line
    assert np.array_equal(result, stylize(picture, without(style), "cpu"))
    caplog.clear()
    stylize(picture, without(style), "cpu")
    assert not [record for record in caplog.records if "focus" in record.message]


def test_large_faces_have_no_focus() -> None:
    assert PLACE.height / 480 < FACE_RATIOS[0] < FACE_RATIOS[1] < 130 / 260


def test_features_come_from_the_cleaned_picture() -> None:
    """Else noise and blocks of JPEG return as specks of faces; and patches are not cleaned a second time."""
    _, data = cv2.imencode(".jpg", picture_with_face()[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, 25])
    dirty = cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1]
    clean = flatten_still(FrameRequest(Picture.from_array(dirty)), 1).picture.color
    assert clean is not None and not np.array_equal(clean, dirty)
    chosen = load_style("ink")
    made = focused_on([PLACE], dirty, chosen)
    assert np.array_equal(made, focused_on([PLACE], clean, replace(chosen, steady=0)))
