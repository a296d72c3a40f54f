"""Faces of still pictures: found once, and shown in previews as in the result."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from focus import PLACE
from pictures import picture_with_face

from vidstyle.core.picture import Picture
from vidstyle.design.restyling import Restyler
from vidstyle.explore.page.exploration import Exploration, styled_jpeg
from vidstyle.gallery.style_samples import restyle_picture, samples_of
from vidstyle.preview.clip import Clip, open_clip
from vidstyle.regions.faces import FaceFinder, is_colorful
from vidstyle.regions.mask_renderer import MaskRenderer
from vidstyle.regions.still_faces import NO_FACES, KnownFaces, StillFaces
from vidstyle.renderer import open_renderer, stylize
from vidstyle.style import Style, load_style

pytestmark = pytest.mark.usefixtures("faces_alone")


@pytest.fixture
def searches(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Gets an entry for each search for faces."""
    made, find = list[int](), FaceFinder.find

    def counted(self: FaceFinder, color: np.ndarray, least: float = 0.05) -> dict:
        made.append(1)
        return find(self, color, least)

    monkeypatch.setattr(FaceFinder, "find", counted)
    return made


@pytest.fixture
def clip(tmp_path: Path) -> Clip:
    cv2.imwrite(str(tmp_path / "face.png"), picture_with_face()[..., ::-1])
    return open_clip(tmp_path / "face.png")


@pytest.fixture
def restyler() -> Restyler:
    return Restyler("cpu")


def style(focus: float = 1.0) -> Style:
    return replace(load_style("comic"), steady=0.0, focus=focus)


def test_a_picture_is_searched_once_for_all_sizes(searches: list[int]) -> None:
    faces, large = StillFaces(), picture_with_face()
    assert not faces.show("a")
    for _ in range(3):
        found = faces.find("a", lambda: large)
    assert faces.show("a") and searches == [1]
    small = cv2.resize(large, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    for picture, scale in ((large, 1.0), (small, 0.5)):
        for source in (faces, found):
            (face,) = source.follow(Picture.from_array(picture), None)
            assert np.allclose(face.box, PLACE.scaled(scale), atol=12 * scale)
    tiny = Picture.from_array(np.ascontiguousarray(large[::24, ::24]))
    assert not faces.show("b") and faces.follow(tiny, None) == found.follow(tiny, None) == ()


def test_a_sheet_of_styles_shows_focus(searches: list[int]) -> None:
    """As `stylize` does; the picture is searched once for all styles."""
    picture, styles = picture_with_face(), [style(), load_style("ink")]
    samples = list(samples_of(picture, styles))
    assert searches == [1]
    for sample in samples:
        assert np.array_equal(sample.picture, stylize(picture, replace(sample.style, steady=0.0), "cpu"))
    assert not np.array_equal(samples[0].picture, restyle_picture(picture, style(), NO_FACES))


def test_tiles_of_the_explorer_show_focus(clip: Clip, searches: list[int]) -> None:
    with Exploration(clip) as exploration:
        searches.clear()
        made = [exploration.styled(style(), 0, 360).result() for _ in range(2)]
    assert searches == [1] and made[0] == made[1]
    frame = np.ascontiguousarray(clip.frame(0, 360))
    assert made[0] != styled_jpeg(frame, style(), NO_FACES, 360, 360)


def test_the_designer_finds_faces_once_a_picture_is_still(
    restyler: Restyler, clip: Clip, searches: list[int]
) -> None:
    """A preview during edits does not wait for them; the larger one does, and later previews have them."""
    first, more = restyler.render_preview(style(), clip, 0, 480)
    large, _ = restyler.render_large(style(), clip, 0, 480)
    again, none_left = restyler.render_preview(style(0.6), clip, 0, 480)
    assert searches == [1] and more
    assert none_left == (min(again.shape[:2]) < 480)
    exact = restyler.render_exactly(style(), clip, 0, 480)
    restyler.close()
    assert searches == [1] and np.array_equal(exact, stylize(picture_with_face(), style(), "cpu"))
    faces = StillFaces().find(0, picture_with_face)

    def expected(shape: tuple[int, ...], focus: float, shown: KnownFaces) -> np.ndarray:
        return restyle_picture(np.ascontiguousarray(clip.frame(0, min(shape[:2]))), style(focus), shown)

    assert np.array_equal(first, expected(first.shape, 1.0, NO_FACES))
    assert np.array_equal(large, expected(large.shape, 1.0, faces))
    assert np.array_equal(again, expected(again.shape, 0.6, faces))
    assert not np.array_equal(again, expected(again.shape, 0.0, faces))


def test_pages_lay_faces_over_their_picture(restyler: Restyler, clip: Clip) -> None:
    """Which is then the same as the server's."""
    faces = restyler.render_faces(style(), clip, 0, 480)
    assert faces is not None and faces.shape == (480, 640, 4) and faces[..., 3].max() == 255
    page = restyle_picture(picture_with_face(), style(0.0))
    alpha = faces[..., 3:] / 255
    mixed = np.rint(page + alpha * (faces[..., :3].astype(float) - page))
    assert np.abs(mixed - stylize(picture_with_face(), style(), "cpu")).max() <= 1
    assert restyler.render_faces(style(0.0), clip, 0, 480) is None
    restyler.close()


@pytest.mark.parametrize("render", [Restyler.render_large, Restyler.render_faces])
def test_without_networks_previews_have_no_focus(
    render: Callable[..., object], clip: Clip, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("vidstyle.regions.faces.weights_folder", lambda: None)
    bare = Restyler("cpu")
    made = render(bare, style(), clip, 0, 480)
    bare.close()
    if isinstance(made, tuple):
        shown = np.ascontiguousarray(clip.frame(0, min(made[0].shape[:2])))
        assert np.array_equal(made[0], restyle_picture(shown, style(0.0)))
    else:
        assert made is None


def test_a_renderer_takes_known_faces() -> None:
    faces = StillFaces()
    faces.find(0, picture_with_face)
    renderer = open_renderer(style(), "cpu", announce=False, faces=faces)
    assert isinstance(renderer, MaskRenderer)
    assert renderer.overlay(Picture.from_array(picture_with_face())) is None
    faces.show(0)
    assert renderer.overlay(Picture.from_array(picture_with_face())) is not None
    renderer.close()


@pytest.mark.parametrize("level", [0, 90, 255])
def test_only_pictures_with_colours_are_searched_for_skin(level: int) -> None:
    """Faces in black and white are found, too."""
    gray = np.full((40, 60, 3), level, np.uint8)
    tinted = gray.copy()
    tinted[..., 2] ^= 0x20
    assert not is_colorful(gray) and is_colorful(tinted)
    assert not is_colorful(np.repeat(picture_with_face()[..., :1], 3, axis=2))
    assert is_colorful(picture_with_face())
