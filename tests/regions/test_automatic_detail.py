"""The level of detail of whole pictures: finer marks for small faces, and coarser ones in a small picture."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from media import photograph
from pictures import picture_with_face

from vidstyle.comic.output.panel_renderer import PanelRenderer
from vidstyle.core.picture import Encoding, Picture
from vidstyle.core.scene_cuts import KnownCuts
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.design.restyling import Restyler, render_second
from vidstyle.live.hot_swap import HotSwapRenderer
from vidstyle.media.read.reader import ReadOptions
from vidstyle.media.write.writer import WriteOptions
from vidstyle.pipeline.resume import setting_parts
from vidstyle.preview.clip import open_clip
from vidstyle.regions.automatic_detail import MAX_DETAIL, face_detail, with_detail
from vidstyle.regions.boxes import Box, Rectangle
from vidstyle.regions.face_tracks import MIN_PICTURE_SIDE_PX, FaceFollower, find_boxes
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.focus import FocusRenderer
from vidstyle.regions.still_faces import KnownFaces, StillFaces
from vidstyle.renderer import open_renderer, restyle_array, stylize
from vidstyle.style import load_style, override, set_values

pytestmark = pytest.mark.usefixtures("without_writing")

LARGE, SMALL = Box(0, 0, 240, 300), Box(0, 0, 24, 30)
"""Faces in a picture of 1080 lines."""


def crowd(faces: int, height: int) -> np.ndarray:
    """Return a picture of 480 lines with copies of a face of about this height."""
    head = photograph("astronaut")[20:220, 130:330]
    scale = height / 117
    head = cv2.resize(head, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    picture = np.full((480, 640, 3), (90, 110, 140), np.uint8)
    side = len(head)
    for number in range(faces):
        top, left = 20 + number // 6 * (side + 10), 10 + number % 6 * 104
        picture[top : top + side, left : left + side] = head
    return picture


@pytest.mark.parametrize(
    ("faces", "detail"),
    [
        ([], 1.0),
        ([LARGE], 1.0),
        ([LARGE.scaled(0.4)], 1.25),
        ([SMALL], 1.5),
        ([SMALL] * 3, 2.0),
        ([SMALL] * 20, MAX_DETAIL),
        ([SMALL.scaled(2)] * 20, 1.75),
        ([LARGE, *[SMALL] * 20], 1.0),
    ],
    ids=("none", "large", "smaller", "small", "three", "many", "larger", "one in front"),
)
def test_small_faces_need_finer_marks(faces: list[Box[float]], detail: float) -> None:
    assert face_detail(faces, 1080) == detail


def test_the_level_of_detail_that_a_user_chooses_wins() -> None:
    style = load_style("ink")
    assert with_detail(style, 2).height == 2 * style.height
    assert with_detail(replace(style, behind=style), 2).behind.height == 2 * style.height
    for other in (replace(style, keeps_detail=True), replace(style, focus=0), replace(style, height=None)):
        assert with_detail(other, 2).height == other.height


def test_crowds_are_drawn_with_finer_marks() -> None:
    picture, style = photograph("astronaut")[:240, :320], load_style("comic")
    known = KnownFaces(detail=2.0)
    with FocusRenderer(style, lambda style, _: CpuRenderer(style), known) as renderer:
        drawn = restyle_array(renderer, picture, seen_side=480)
        overlay = renderer.overlay(Picture.from_array(picture), seen_side=480)
    assert (drawn == stylize(picture, replace(style, height=2 * style.height, focus=0))).all()
    assert (overlay[..., :3] == drawn).all() and overlay[..., 3].all()


@pytest.mark.parametrize("time", [None, 0.0])
@pytest.mark.parametrize("has_model", [True, False], ids=["faces", "no package"])
def test_marks_of_small_pictures_keep_their_size(
    time: float | None, has_model: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also where no face is searched, in pictures of fewer lines or without the networks."""
    if not has_model:
        monkeypatch.setattr("vidstyle.regions.faces.weights_folder", lambda: None)
    style = replace(load_style("mosaic"), focus=0.5)
    for side in (MIN_PICTURE_SIDE_PX, MIN_PICTURE_SIDE_PX - 1):
        picture = picture_with_face(None)[:side, :320]
        with open_renderer(style, "cpu") as renderer:
            drawn = restyle_array(renderer, picture, time)
        assert (drawn == stylize(picture, replace(style, height=style.height * side / 480, focus=0))).all()


def test_reduced_copies_are_no_small_pictures() -> None:
    """Also in a live film that is restyled at half its size."""
    picture, style = picture_with_face(None)[:320, :400], replace(load_style("mosaic"), focus=0.5)
    plain = stylize(picture, replace(style, focus=0), "cpu")
    with open_renderer(style, "cpu") as renderer:
        assert (restyle_array(renderer, picture, seen_side=640) == plain).all()
        assert (restyle_array(renderer, picture) != plain).any()
    large = Picture.from_array(np.repeat(np.repeat(picture, 2, 0), 2, 1))
    results = []
    for focus in (0.5, 0.0):
        live = HotSwapRenderer(replace(style, focus=focus), "cpu", pytest.fail)
        live.scale = 0.5
        results.append(live.run(large, 0.0, Encoding(full_range=True, subsampling=(1, 1)), live.style)[0])
        live.close(5)
    assert (results[0].luma == results[1].luma).all()


def test_previews_are_no_small_pictures(tmp_path: Path) -> None:
    """The designer's have the marks of the picture that it renders."""
    cv2.imwrite(str(tmp_path / "table.png"), picture_with_face(None)[..., ::-1])
    clip, style = open_clip(tmp_path / "table.png"), replace(load_style("mosaic"), focus=0.5)
    restyler = Restyler("cpu")
    renders = (
        restyler.render_exactly,
        lambda *each: restyler.render_large(*each)[0],
        lambda *each: next(render_second(*each, lambda: False))[2],
    )
    for render in renders:
        one, other = (render(replace(style, focus=focus), clip, 0, 180) for focus in (0.5, 0.0))
        assert (one == other).all()
    restyler.close()


@pytest.mark.parametrize("time", [None, 0.0])
def test_a_picture_does_not_get_the_level_of_the_one_before(time: float | None) -> None:
    with FaceFollower(FaceFinder()) as follower:
        follower.follow(Picture.from_array(crowd(6, 26)), time)
        assert follower.detail > 1
        follower.follow(Picture.from_array(crowd(0, 26)[:200]), time)
        assert follower.detail == 1


def test_previews_of_a_still_have_its_level() -> None:
    """As its render has."""
    picture, previewed = crowd(6, 26), StillFaces()
    previewed.find("crowd", lambda: picture)
    assert previewed.show("crowd")
    with FaceFollower(FaceFinder()) as follower:
        follower.follow(Picture.from_array(picture), None)
    assert previewed.detail == follower.detail > 1


def test_panels_have_marks_for_paper() -> None:
    style, picture = replace(load_style("mosaic"), focus=0.5), picture_with_face(None)
    windows = Box(0, 0, 640, 480), Rectangle(0, 0, 320, 240)
    panels = []
    for each in (style, replace(style, focus=0.0)):
        with PanelRenderer([each], 100, "cpu", announce=False) as renderer:
            panels.append(renderer.panel(picture, *windows))
    assert (panels[0] == panels[1]).all()


def test_a_height_that_a_user_chooses_wins() -> None:
    for style in (
        override(load_style("ink"), ["height=900"]),
        set_values(load_style("ink"), {"height": 900}),
    ):
        assert with_detail(set_values(style, {"steady": 0}), 2).height == 900
    other = replace(style, keeps_detail=False)
    assert len({setting_parts(each, ReadOptions(), WriteOptions())["style"] for each in (style, other)}) == 2


def test_smaller_faces_are_searched_around_small_ones() -> None:
    """In a still with faces of at least 5 % of its lines, smaller ones are found too."""
    mixed, smaller = crowd(6, 26), crowd(24, 14)
    mixed[100:] = smaller[:380]
    first, more = (find_boxes(FaceFinder(), Picture.from_array(mixed), each) for each in (False, True))
    assert len(first) == 6 and len(more) >= 24


def test_marks_keep_their_size_within_a_scene() -> None:
    cuts, full, empty = KnownCuts((0.4,)), crowd(6, 26), crowd(0, 26)
    with FaceFollower(FaceFinder(), cuts) as follower:
        details = list[float]()
        for time, each in ((0.0, full), (0.2, empty), (0.4, empty), (0.6, full)):
            follower.follow(Picture.from_array(each), time)
            details.append(follower.detail)
    assert details[0] == details[1] > 1 and details[2:] == [1.0, 1.0]
