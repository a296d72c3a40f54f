"""The level of detail of whole pictures: finer marks for small faces, and coarser ones in a small picture."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from media import photograph
from pictures import picture_with_face

from vidstyle.core.picture import Picture
from vidstyle.core.scene_cuts import KnownCuts
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.regions.automatic_detail import MAX_DETAIL, face_detail, with_detail
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import FaceFollower, find_boxes
from vidstyle.regions.faces import FaceFinder
from vidstyle.regions.features.landmarks import USUAL_LANDMARKS, MarkedFaces
from vidstyle.regions.focus import FocusRenderer
from vidstyle.regions.still_faces import KnownFaces
from vidstyle.renderer import open_renderer, restyle_array, stylize
from vidstyle.style import load_style

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
    for other in (replace(style, has_detail=True), replace(style, focus=0), replace(style, height=None)):
        assert with_detail(other, 2).height == other.height


def test_crowds_are_drawn_with_finer_marks() -> None:
    picture, style = photograph("astronaut")[:240, :320], load_style("comic")
    known = KnownFaces(detail=2.0)
    with FocusRenderer(style, lambda style, _: CpuRenderer(style), known) as renderer:
        drawn = restyle_array(renderer, picture)
        overlay = renderer.overlay(Picture.from_array(picture))
    assert (drawn == stylize(picture, replace(style, height=2 * style.height, focus=0))).all()
    assert (overlay[..., :3] == drawn).all() and overlay[..., 3].all()


@pytest.mark.parametrize("time", [None, 0.0])
def test_marks_of_small_pictures_keep_their_size(time: float | None) -> None:
    picture, style = picture_with_face(None)[:320, :400], replace(load_style("mosaic"), focus=0.5)
    with open_renderer(style, "cpu") as renderer:
        drawn = restyle_array(renderer, picture, time)
    assert (drawn == stylize(picture, replace(style, height=style.height * 320 / 480, focus=0))).all()


def test_small_faces_are_searched_where_most_are_small() -> None:
    class Finder(FaceFinder):
        """Finds six faces; among more proposals of lower height also others."""

        def find(self, color: np.ndarray, least: float = 0.05, max_proposals: int = 40) -> MarkedFaces:
            count = 20 if least < 0.02 and max_proposals > 100 else 6
            return {SMALL.moved(30 * number, 0): USUAL_LANDMARKS for number in range(count)}

    picture = Picture.from_array(np.zeros((720, 900, 3), np.uint8))
    assert [len(find_boxes(Finder(), picture, each)) for each in (False, True)] == [6, 20]


def test_marks_keep_their_size_within_a_scene() -> None:
    cuts, full, empty = KnownCuts((0.4,)), crowd(6, 26), crowd(0, 26)
    with FaceFollower(FaceFinder(), cuts) as follower:
        details = list[float]()
        for time, each in ((0.0, full), (0.2, empty), (0.4, empty), (0.6, full)):
            follower.follow(Picture.from_array(each), time)
            details.append(follower.detail)
    assert details[0] == details[1] > 1 and details[2:] == [1.0, 1.0]
