"""Faces of films keep their windows and their marks from frame to frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from covering import of_the_day
from focus import PLACE, below_white, planes, without
from pictures import FACE, film_with_face, picture_with_face

from vidstyle.backend import FrameRequest
from vidstyle.core.picture import Picture
from vidstyle.core.scene_cuts import KnownCuts, SceneCuts
from vidstyle.cpu.renderer import CpuRenderer
from vidstyle.regions.boxes import Box
from vidstyle.regions.face_tracks import Face
from vidstyle.regions.patch_renderer import PatchRenderer
from vidstyle.regions.patches import Patch, PatchSet, plane_area
from vidstyle.regions.rasters import NO_RASTER
from vidstyle.renderer import open_renderer
from vidstyle.style import Style, load_style, style_from_table

pytestmark = pytest.mark.usefixtures("faces_alone")


def test_a_film_is_the_same_in_any_way_to_run_it() -> None:
    """Pictures in flight, and one after another; the source is only read."""
    frames = film_with_face(lambda number: 200 + 2 * number, 12)
    copies = [picture.color.copy() for picture, _ in frames if picture.color is not None]
    style, results = load_style("comic"), []
    for in_flight in (True, False):
        renderer = open_renderer(style, "cpu")
        pending = [
            renderer.begin(FrameRequest(*frame)) if in_flight else renderer.run(*frame) for frame in frames
        ]
        pictures = [each if isinstance(each, Picture) else each.result() for each in pending]
        results.append([planes(each)[0] for each in pictures])
        renderer.close()
    assert all(map(np.array_equal, *results))
    assert all(np.array_equal(picture.color, copy) for (picture, _), copy in zip(frames, copies, strict=True))


def test_a_scene_does_not_depend_on_the_scene_before() -> None:
    """Though its face appears later than the scene begins: segments of a film join without a seam."""
    before = [(below_white(picture), time) for picture, time in film_with_face(lambda _: 250, 8)]
    after = film_with_face(lambda number: 250 if number > 3 else None, 40)
    later, results = [(picture, time + 0.32) for picture, time in after], list[list[np.ndarray]]()
    style = style_from_table(
        {"format": 1, "height": 720, "background": [{"block": "equalize", "settle": 2}]}, "equal"
    )
    for each, frames in ((style, before + later), (style, later), (without(style), later)):
        renderer = open_renderer(each, "cpu", cuts=KnownCuts([0.0, 0.32]))
        results.append([planes(renderer.run(*frame))[0] for frame in frames][-len(later) :])
        renderer.close()
    assert all(map(np.array_equal, *results[:2]))
    assert not np.array_equal(results[0][-1], results[2][-1])


@pytest.mark.parametrize("name", of_the_day(["comic", "manga"], 1))
def test_marks_do_not_jump_while_a_face_moves(name: str) -> None:
    """The greatest change from frame to frame around a slow face is near the mean, though windows change."""
    frames = film_with_face(lambda number: 100 + number, 40)
    renderer, changes, before = open_renderer(replace(load_style(name), steady=0.0), "cpu"), [], None
    for number, (picture, time) in enumerate(frames):
        color = renderer.run(picture, time, rgb=True).color
        assert color is not None
        if before is not None:
            area = plane_area(Box(*map(round, FACE.moved(100 + number, 150))), (1, 1))
            changes.append(float(np.abs(color[area].astype(int) - before[area]).mean()))
        before = color
    renderer.close()
    assert max(changes) < 1.4 * np.mean(changes)


def test_a_film_may_begin_after_pictures_that_are_skipped() -> None:
    """As where a render is continued: faces then have the windows of the whole film, and so their marks."""
    frames = film_with_face(lambda number: 150 + 3 * number if number > 2 else None, 40)
    style, results = replace(load_style("comic"), steady=0.0), list[np.ndarray]()
    for skipped, begun in ((0, 0), (30, 30), (0, 30)):
        renderer = open_renderer(style, "cpu")
        for frame in frames[:skipped]:
            renderer.skip(FrameRequest(*frame))
        pictures = [renderer.run(*frame) for frame in frames[begun:]]
        results.append(np.array([planes(each)[0].astype(int) for each in pictures][-5:]))
        renderer.close()
    # Percentiles of the style have not quite settled.
    continued, fresh = (np.mean(np.abs(results[0] - each)) for each in results[1:])
    assert continued < 0.25 * fresh


def test_only_new_windows_begin_a_scene_of_the_patches() -> None:
    """A single picture begins none: it has no time."""
    known: list[SceneCuts | None] = []

    def open_backend(style: Style, cuts: SceneCuts | None) -> CpuRenderer:
        known.append(cuts)
        return CpuRenderer(style, cuts=cuts)

    picture = Picture.from_array(picture_with_face())
    patch = Patch(Box(200, 100, 460, 360), Box(0, 0, 260, 260), Face(1, PLACE, 1.0))
    times = 0.0, 0.04, 0.08, None
    with PatchRenderer(open_backend) as renderer:
        for time, is_new in zip(times, (True, False, True, True), strict=True):
            patches = PatchSet(1, (patch,), is_new, PLACE.height)
            renderer.prepare(FrameRequest(picture, time), patches, load_style("ink"), 1.0, NO_RASTER)
    (cuts,) = known
    assert cuts is not None
    assert [cuts.begins_scene(picture, time) for time in times] == [True, False, True, False]
